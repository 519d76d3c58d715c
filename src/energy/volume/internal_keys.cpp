#include "energy/volume/internal_keys.hpp"

#include "energy/volume/point_tensor.hpp"
#include "fem/element.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>

namespace pliant {
namespace {

constexpr int point_bits = 14;  // per coordinate: 6e-5 distinguishes all points of a rule
constexpr std::int64_t most_per_term = 1024;

}  // namespace

std::vector<EntryKey> internal_keys(const NodeLayout& layout, std::span<const EnergyTerm* const> terms) {
  std::vector<EntryKey> keys;
  for (std::size_t k = 0; k < terms.size(); ++k) {
    std::vector<InternalPlace> places(terms[k]->num_internal() / num_symmetric);
    terms[k]->place_internal(places);
    for (const auto& place : places) {
      assert(place.number < most_per_term);
      const auto nodes = layout.nodes_of_cell(place.cell);
      const auto coordinates = Simplex<3, 1>::values(place.point);
      std::array<std::pair<std::int64_t, double>, 4> corners;
      for (std::size_t a = 0; a < 4; ++a) corners[a] = {layout.vertex_numbers[nodes[a]], coordinates[a]};
      std::ranges::sort(corners);
      std::int64_t key = static_cast<std::int64_t>(k) * most_per_term + place.number;
      for (std::size_t a = 1; a < 4; ++a) {
        key = (key << point_bits) + std::llround(std::ldexp(corners[a].second, point_bits - 1));
      }
      keys.push_back({layout.cell_numbers[place.cell], key});
    }
  }
  return keys;
}

}  // namespace pliant
