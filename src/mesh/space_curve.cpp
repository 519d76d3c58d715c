#include "mesh/space_curve.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

namespace pliant {
namespace {

constexpr int bits_per_axis = 21;

/// Inserts two zeros between the bits of x.
std::uint64_t spread(std::uint64_t x) {
  std::uint64_t result = 0;
  for (int i = 0; i < bits_per_axis; ++i) result |= (x >> i & 1u) << (3 * i);
  return result;
}

/// Position of each cell's centroid along the curve (Morton 1966): interleaves the bits of the coordinates.
std::vector<std::uint64_t> positions(const SerialMesh& mesh) {
  std::array<double, 3> lower{HUGE_VAL, HUGE_VAL, HUGE_VAL};
  double extent = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    double upper = -HUGE_VAL;
    for (std::size_t i = 0; i < mesh.num_nodes(); ++i) {
      lower[k] = std::min(lower[k], mesh.coordinates[3 * i + k]);
      upper = std::max(upper, mesh.coordinates[3 * i + k]);
    }
    extent = std::max(extent, upper - lower[k]);
  }
  const double scale = ((1 << bits_per_axis) - 1) / (4.0 * extent);  // for the sum over four corners
  std::vector<std::uint64_t> result(mesh.num_cells());
  for (std::size_t c = 0; c < result.size(); ++c) {
    for (std::size_t k = 0; k < 3; ++k) {
      double sum = -4.0 * lower[k];
      for (std::size_t i = 0; i < 4; ++i) sum += mesh.node(mesh.cells[4 * c + i])[k];
      result[c] |= spread(static_cast<std::uint64_t>(std::max(0.0, scale * sum))) << k;
    }
  }
  return result;
}

/// `values`, `size` per item, in the order of the items.
template <class T>
void reorder(std::vector<T>& values, std::size_t size, const std::vector<PetscInt>& order) {
  if (values.empty()) return;
  std::vector<T> sorted(values.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(size) * order[i], size,
                sorted.begin() + static_cast<std::ptrdiff_t>(size * i));
  }
  values = std::move(sorted);
}

std::vector<PetscInt> inverse(const std::vector<PetscInt>& order) {
  std::vector<PetscInt> result(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    result[static_cast<std::size_t>(order[i])] = static_cast<PetscInt>(i);
  }
  return result;
}

void renumber(std::vector<PetscInt>& list, const std::vector<PetscInt>& number) {
  for (PetscInt& i : list) {
    if (i >= 0) i = number[static_cast<std::size_t>(i)];
  }
}

void sort_cells(SerialMesh& mesh) {
  const std::vector<std::uint64_t> position = positions(mesh);
  std::vector<PetscInt> order(mesh.num_cells());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](PetscInt c, PetscInt d) {
    return position[static_cast<std::size_t>(c)] < position[static_cast<std::size_t>(d)];
  });
  reorder(mesh.cells, 4, order);
  reorder(mesh.cell_tags, 1, order);
  for (auto& data : mesh.cell_data) reorder(data.values, static_cast<std::size_t>(data.components), order);
  const std::vector<PetscInt> number = inverse(order);
  for (auto& group : mesh.groups) {
    if (group.group.dimension == 3) renumber(group.members, number);
  }
}

void number_nodes_by_cells(SerialMesh& mesh) {
  std::vector<PetscInt> order;
  order.reserve(mesh.num_nodes());
  std::vector<bool> seen(mesh.num_nodes(), false);
  for (const PetscInt node : mesh.cells) {
    if (seen[static_cast<std::size_t>(node)]) continue;
    seen[static_cast<std::size_t>(node)] = true;
    order.push_back(node);
  }
  reorder(mesh.coordinates, 3, order);
  reorder(mesh.node_tags, 1, order);
  const std::vector<PetscInt> number = inverse(order);
  renumber(mesh.cells, number);
  for (auto& group : mesh.groups) {
    if (group.group.dimension < 3) renumber(group.members, number);
  }
}

}  // namespace

void sort_along_curve(SerialMesh& mesh) {
  sort_cells(mesh);
  number_nodes_by_cells(mesh);
}

}  // namespace pliant
