#include "mesh/added_tetrahedra.hpp"

#include "mesh/added_nodes.hpp"
#include "mesh/added_volumes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace pliant {
namespace {

/// The eight tetrahedra between corners and middles of edges, oriented as the whole.
std::vector<CornerNodes> cut(const CornerNodes& c, AddedNodes& nodes) {
  const PetscInt a = nodes.middle(c[0], c[1]), b = nodes.middle(c[0], c[2]), d = nodes.middle(c[0], c[3]),
                 e = nodes.middle(c[1], c[2]), f = nodes.middle(c[1], c[3]), g = nodes.middle(c[2], c[3]);
  return {{c[0], a, b, d}, {a, c[1], e, f}, {b, e, c[2], g}, {d, f, g, c[3]},
          {a, b, d, f},    {a, e, b, f},    {b, g, d, f},    {b, e, g, f}};
}

/// The largest side of the box around all nodes.
double largest_side(const SerialMesh& mesh) {
  double largest = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (std::size_t i = axis; i < mesh.coordinates.size(); i += 3) {
      low = std::min(low, mesh.coordinates[i]);
      high = std::max(high, mesh.coordinates[i]);
    }
    largest = std::max(largest, high - low);
  }
  return largest;
}

/// Shrinks it about its middle to a half diagonal of `most` at most.
void shrink(AddedTetrahedron& body, double most) {
  std::array<double, 3> middle{};
  for (const auto& X : body.corners) {
    for (std::size_t i = 0; i < 3; ++i) middle[i] += 0.25 * X[i];
  }
  const auto from_middle = [&](std::size_t i) { return body.corners[0][i] - middle[i]; };
  const double size = std::hypot(from_middle(0), from_middle(1), from_middle(2));
  if (size <= most) return;
  for (auto& X : body.corners) {
    for (std::size_t i = 0; i < 3; ++i) X[i] = middle[i] + most / size * (X[i] - middle[i]);
  }
}

}  // namespace

void add_tetrahedra(std::span<const AddedTetrahedron> added, SerialMesh& mesh) {
  if (added.empty()) return;
  const bool has_middles = mesh.geometry_order() == 2;
  // The same for any number of ranks: runs are resumed on others.
  const std::size_t cells_of_each = mesh.num_cells() == 0 ? 8 : 1;
  // Their masses and moments are the input's, whatever their size. No two have the same one, or corners may coincide.
  constexpr double largest_share = 0.43, difference = 1.37e-4;  // 0.43: a sphere of a quarter of the side as its radius
  const double side = mesh.num_cells() == 0 ? std::numeric_limits<double>::infinity() : largest_side(mesh);
  std::size_t number = 0;
  for (AddedTetrahedron body : added) {
    shrink(body, largest_share * side * (1.0 - difference * static_cast<double>(number++)));
    AddedNodes nodes(mesh);
    CornerNodes corners{};
    for (std::size_t k = 0; k < 4; ++k) corners[k] = nodes.add(body.corners[k]);
    std::vector<CornerNodes> cells{corners};
    while (cells.size() < cells_of_each) {
      std::vector<CornerNodes> finer;
      for (const CornerNodes& cell : cells) {
        for (const CornerNodes& part : cut(cell, nodes)) finer.push_back(part);
      }
      cells = std::move(finer);
    }
    std::vector<PetscInt> members;
    for (const CornerNodes& cell : cells) members.push_back(nodes.add_cell(cell, has_middles));
    add_volume_group(body.name, std::move(members), mesh);
  }
  complete_cell_data(mesh);
}

}  // namespace pliant
