#include "energy/rod/rod_pairs.hpp"

#include "petsc/collective.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

namespace pliant {

// All ranks know the segments, and learn their nodes.
FixedPairs pairs_of_neighbours(const NodeLayout& layout, const Patches& patches,
                               std::span<const std::ptrdiff_t> vertex_after) {
  FixedPairs fixed;
  const std::size_t num_segments = vertex_after.size();
  struct Known {
    std::int64_t number = 0;
    std::array<std::int64_t, 4> nodes{};
  };
  constexpr std::size_t unknown = std::numeric_limits<std::size_t>::max();
  std::vector<Known> mine;
  std::vector<std::size_t> place(num_segments, unknown);
  for (std::size_t p = 0; p < patches.size(); ++p) {
    const auto nodes = patches.nodes_of(p);
    place[static_cast<std::size_t>(patches.keys[p])] = p;
    if (patches.is_owned[p] == 0) continue;
    Known& known = mine.emplace_back();
    known.number = patches.keys[p];
    for (std::size_t a = 0; a < 4; ++a) known.nodes[a] = layout.global_node(nodes[a]);
  }
  std::vector<std::array<std::int64_t, 4>> nodes(num_segments, std::array<std::int64_t, 4>{});
  for (const Known& known : gathered(layout.comm, mine)) nodes[static_cast<std::size_t>(known.number)] = known.nodes;
  const auto has_owned_node = [&](std::size_t segment) {
    return std::ranges::any_of(nodes[segment], [&](std::int64_t node) {
      return node >= layout.first_global_node && node < layout.first_global_node + layout.num_owned_nodes;
    });
  };
  const auto place_of = [&](std::size_t segment) {
    if (place[segment] != unknown) return place[segment];
    place[segment] = patches.size() + fixed.keys.size();
    fixed.keys.push_back(static_cast<std::int64_t>(segment));
    fixed.tags.push_back(0);
    for (const std::int64_t node : nodes[segment]) fixed.global_nodes.push_back(static_cast<PetscInt>(node));
    return place[segment];
  };
  for (std::size_t s = 0; s < num_segments; ++s) {
    if (vertex_after[s] < 0 || !(has_owned_node(s) || has_owned_node(s + 1))) continue;
    const std::size_t first = place_of(s), second = place_of(s + 1);
    fixed.pairs.push_back({first, second});
  }
  return fixed;
}

}  // namespace pliant
