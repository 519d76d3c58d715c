#include "energy/volume/internal_keys.hpp"

#include "fem/element.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>

namespace pliant {
namespace {

constexpr int point_bits = 13;  // per coordinate: 2e-4 distinguishes all points of a rule
constexpr std::int64_t most_per_term = 1024;
constexpr std::int64_t most_components = 8;

}  // namespace

int internal_components(std::span<const EnergyTerm* const> terms) {
  // Not whether this rank has such entries: all ranks write and read rows of one width.
  const bool have_numbers =
      std::ranges::any_of(terms, [](const EnergyTerm* term) { return term->internal_components() == 1; });
  return have_numbers ? 1 : num_symmetric;
}

std::vector<EntryKey> internal_keys(const NodeLayout& layout, std::span<const EnergyTerm* const> terms) {
  std::vector<EntryKey> keys;
  const int shared = internal_components(terms);
  for (std::size_t k = 0; k < terms.size(); ++k) {
    const int components = terms[k]->internal_components();
    std::vector<InternalPlace> places(terms[k]->num_internal() / static_cast<std::size_t>(components));
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
      for (int c = 0; c < components; c += shared) {
        keys.push_back({layout.cell_numbers[place.cell], most_components * key + c});
      }
    }
  }
  return keys;
}

}  // namespace pliant
