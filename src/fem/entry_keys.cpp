#include "fem/entry_keys.hpp"

#include "fem/element.hpp"

#include <algorithm>
#include <bit>

namespace pliant {
namespace {

/// A 64-bit hash that any change of the argument changes completely. Source: Steele, Lea & Flood 2014,
/// "Fast splittable pseudorandom number generators", the finalizer of SplitMix64.
std::uint64_t mixed(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

std::uint64_t mixed(std::uint64_t seed, std::int64_t x) {
  return mixed(seed ^ mixed(static_cast<std::uint64_t>(x)));
}

}  // namespace

std::vector<EntryKey> node_keys(const NodeLayout& layout) {
  std::vector<EntryKey> keys(static_cast<std::size_t>(layout.num_owned_nodes));
  const auto put = [&](PetscInt node, PetscInt from, PetscInt to) {
    if (node >= layout.num_owned_nodes) return;
    const std::int64_t a = layout.vertex_numbers[from], b = layout.vertex_numbers[to];
    keys[node] = {std::min(a, b), std::max(a, b)};
  };
  for (PetscInt c = 0; c < layout.num_local_cells; ++c) {
    const auto nodes = layout.nodes_of_cell(c);
    for (int a = 0; a < 4; ++a) put(nodes[a], nodes[a], nodes[a]);
    for (int a = 4; a < layout.nodes_per_cell; ++a) {
      const auto [from, to] = tet_edges[a - 4];
      put(nodes[a], nodes[from], nodes[to]);
    }
  }
  return keys;
}

std::vector<EntryKey> pressure_keys(const NodeLayout& layout, const PressureLayout& pressures) {
  const std::vector<EntryKey> of_node = node_keys(layout);
  std::vector<EntryKey> keys(static_cast<std::size_t>(pressures.num_owned));
  for (std::size_t body = 0; body < pressures.of_node.size(); ++body) {
    for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) {
      const PetscInt p = pressures.of_node[body][n];
      if (p >= 0) keys[p] = {of_node[n].first, static_cast<std::int64_t>(body)};
    }
  }
  return keys;
}

std::uint64_t fingerprint(const NodeLayout& layout) {
  std::uint64_t total = 0;
  const auto keys = node_keys(layout);
  for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) {
    std::uint64_t node = mixed(mixed(1, keys[n].first), keys[n].second);
    for (const double x : layout.position(n)) node = mixed(node, std::bit_cast<std::int64_t>(x + 0.0));
    total += node;
  }
  for (PetscInt c = 0; c < layout.num_owned_cells; ++c) {
    std::uint64_t cell = mixed(2, layout.cell_numbers[c]);
    for (const PetscInt n : layout.nodes_of_cell(c).first(4)) cell += mixed(3, layout.vertex_numbers[n]);
    total += mixed(cell);
  }
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &total, 1, MPI_UINT64_T, MPI_SUM, layout.comm));
  return total;
}

}  // namespace pliant
