#include "fem/entry_keys.hpp"

#include "petsc/plex.hpp"

#include <algorithm>
#include <bit>

namespace pliant {
namespace {

/// One of 2^64 numbers, changed beyond recognition by any change of the argument. Source: Steele, Lea & Flood 2014,
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

MeshNumbers mesh_numbers(const Mesh& mesh, const NodeLayout& layout) {
  const PointRange vertices = stratum(mesh.dm.get(), 0), cells = stratum(mesh.dm.get(), 3);
  MeshNumbers numbers;
  numbers.of_node.assign(static_cast<std::size_t>(layout.num_local_nodes), -1);
  for (PetscInt v = vertices.begin; v < vertices.end; ++v) {
    const PetscInt node = layout.node_of_point[v];
    if (node >= 0) numbers.of_node[node] = mesh.vertex_numbers[v - vertices.begin];
  }
  for (const PetscInt point : layout.cell_points) numbers.of_cell.push_back(mesh.cell_numbers[point - cells.begin]);
  return numbers;
}

std::vector<EntryKey> node_keys(const Mesh& mesh, const NodeLayout& layout) {
  DM dm = mesh.dm.get();
  const PointRange vertices = stratum(dm, 0), edges = stratum(dm, 1);
  std::vector<EntryKey> keys(static_cast<std::size_t>(layout.num_owned_nodes));
  const auto number = [&](PetscInt vertex) {
    return mesh.vertex_numbers[static_cast<std::size_t>(vertex - vertices.begin)];
  };
  const auto put = [&](PetscInt point, PetscInt a, PetscInt b) {
    const PetscInt node = layout.node_of_point[point];
    if (node < 0 || node >= layout.num_owned_nodes) return;
    keys[static_cast<std::size_t>(node)] = {std::min(number(a), number(b)), std::max(number(a), number(b))};
  };
  for (PetscInt v = vertices.begin; v < vertices.end; ++v) put(v, v, v);
  for (PetscInt e = edges.begin; e < edges.end && layout.order == 2; ++e) {
    const PetscInt* ends = ends_of_edge(dm, e);
    put(e, ends[0], ends[1]);
  }
  return keys;
}

std::vector<EntryKey> pressure_keys(const Mesh& mesh, const NodeLayout& layout, const PressureLayout& pressures) {
  const std::vector<EntryKey> of_node = node_keys(mesh, layout);
  std::vector<EntryKey> keys(static_cast<std::size_t>(pressures.num_owned));
  for (std::size_t body = 0; body < pressures.of_node.size(); ++body) {
    for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) {
      const PetscInt p = pressures.of_node[body][n];
      if (p >= 0) keys[p] = {of_node[n].first, static_cast<std::int64_t>(body)};
    }
  }
  return keys;
}

std::uint64_t fingerprint(const Mesh& mesh, const NodeLayout& layout) {
  std::uint64_t total = 0;
  const auto keys = node_keys(mesh, layout);
  for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) {
    std::uint64_t node = mixed(mixed(1, keys[n].first), keys[n].second);
    for (const double x : layout.position(n)) node = mixed(node, std::bit_cast<std::int64_t>(x + 0.0));
    total += node;
  }
  const PointRange vertices = stratum(mesh.dm.get(), 0);
  const PetscInt first_cell = stratum(mesh.dm.get(), 3).begin;
  for (PetscInt c = 0; c < layout.num_owned_cells; ++c) {
    std::uint64_t cell = mixed(2, mesh.cell_numbers[layout.cell_points[c] - first_cell]);
    for_each_in_closure(mesh.dm.get(), layout.cell_points[c], [&](PetscInt p) {
      if (vertices.contains(p)) cell += mixed(3, mesh.vertex_numbers[p - vertices.begin]);
    });
    total += mixed(cell);
  }
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &total, 1, MPI_UINT64_T, MPI_SUM, layout.comm));
  return total;
}

}  // namespace pliant
