#include "fem/cells.hpp"

#include "base/error.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace pliant {
namespace {

Tensor3<double> jacobian(const NodeLayout& layout, std::span<const PetscInt> nodes,
                         std::span<const std::array<double, 3>> dN) {
  Tensor3<double> j{};
  for (std::size_t a = 1; a < nodes.size(); ++a) {
    for (int i = 0; i < 3; ++i) {
      const double d = layout.coordinates[3 * nodes[a] + i] - layout.coordinates[3 * nodes[0] + i];
      for (int k = 0; k < 3; ++k) j(i, k) += d * dN[a][k];
    }
  }
  return j;
}

struct LaneGeometry {
  double jacobian;
  Tensor3<double> inverse;
};

/// The mapping of one cell at a point of the reference cell.
LaneGeometry lane_geometry(const NodeLayout& layout, std::span<const PetscInt> nodes,
                           std::span<const std::array<double, 3>> dN) {
  const Tensor3<double> j = jacobian(layout, nodes, dN);
  const double determinant = det(j);
  if (!(determinant > 0.0)) {
    const auto x = layout.position(nodes[0]);
    throw InputError({},
                     fmt::format("a tetrahedron at ({:.6g}, {:.6g}, {:.6g}) m is turned inside out by its curved edges "
                                 "(Jacobian {:.3g}); optimise the second-order mesh (gmsh -optimize_ho) or refine it",
                                 x[0], x[1], x[2], determinant));
  }
  return {determinant, (1.0 / determinant) * transpose(cofactor(j))};
}

template <int Order>
void fill_geometry(const NodeLayout& layout, CellGroup<Order>& group) {
  const auto num_batches = group.batches.size();
  group.inverse_jacobian.resize(num_batches * group.geometry_points);
  group.jacobian.resize(num_batches * group.geometry_points);
  if (group.shape == CellShape::curved) group.centroid_inverse_jacobian.resize(num_batches);
  const auto centroid = Tet<Order>::gradients({0.25, 0.25, 0.25});
  for (std::size_t b = 0; b < num_batches; ++b) {
    const auto& batch = group.batches[b];
    for (int lane = 0; lane < pack_size; ++lane) {
      std::array<PetscInt, CellGroup<Order>::num_nodes> nodes;
      for (std::size_t a = 0; a < nodes.size(); ++a) nodes[a] = batch.nodes[a][lane];
      if (group.shape == CellShape::curved) {
        const LaneGeometry middle = lane_geometry(layout, nodes, centroid);
        for (int i = 0; i < 9; ++i) group.centroid_inverse_jacobian[b].a[i][lane] = middle.inverse.a[i];
      }
      for (int q = 0; q < group.geometry_points; ++q) {
        const auto dN = group.gradients(q);
        const LaneGeometry here = lane_geometry(layout, nodes, dN);
        const std::size_t at = group.geometry(b, q);
        for (int i = 0; i < 9; ++i) group.inverse_jacobian[at].a[i][lane] = here.inverse.a[i];
        group.jacobian[at][lane] = lane < batch.num_lanes ? here.jacobian : 0.0;
      }
    }
  }
}

template <int Order>
CellGroup<Order> make_group(const NodeLayout& layout, const BlockPattern& pattern, int body, CellShape shape,
                            int degree, const std::vector<PetscInt>& cells) {
  constexpr int n = CellGroup<Order>::num_nodes;
  CellGroup<Order> group;
  group.body = body;
  group.shape = shape;
  group.rule = simplex_rule<3>(degree);
  for (const auto& xi : group.rule.points) {
    group.shape_gradients.push_back(Tet<Order>::gradients(xi));
    group.barycentric_gradients.push_back(Tet<Order>::barycentric_gradients(xi));
  }
  group.geometry_points = shape == CellShape::affine ? 1 : group.rule.size();
  const std::size_t num_batches = (cells.size() + pack_size - 1) / pack_size;
  group.batches.reserve(num_batches);
  group.cells.reserve(num_batches * pack_size);
  group.blocks.reserve(num_batches * n * n);
  for (std::size_t first = 0; first < cells.size(); first += pack_size) {
    auto& batch = group.batches.emplace_back();
    batch.num_lanes = static_cast<int>(std::min<std::size_t>(pack_size, cells.size() - first));
    batch.owned = 0.0;
    for (int lane = 0; lane < pack_size; ++lane) {
      const bool real = lane < batch.num_lanes;
      const PetscInt cell = cells[first + (real ? lane : 0)];
      group.cells.push_back(real ? cell : -1);
      const auto nodes = layout.nodes_of_cell(cell);
      for (int a = 0; a < n; ++a) batch.nodes[a][lane] = nodes[a];
      if (real && cell < layout.num_owned_cells) batch.owned[lane] = 1.0;
    }
    for (int a = 0; a < n; ++a) {
      for (int b = 0; b < n; ++b) {
        auto& block = group.blocks.emplace_back();
        for (int lane = 0; lane < pack_size; ++lane) {
          const PetscInt row = batch.nodes[a][lane];
          block[lane] = row < layout.num_owned_nodes ? pattern.block(row, batch.nodes[b][lane]) : 0;
        }
      }
    }
  }
  fill_geometry(layout, group);
  return group;
}

}  // namespace

template <int Order>
CellGroups<Order> make_cell_groups(const NodeLayout& layout, const BlockPattern& pattern,
                                   const std::vector<int>& body_of_cell, const std::vector<int>& degree_of_body) {
  CellGroups<Order> groups;
  for (std::size_t body = 0; body < degree_of_body.size(); ++body) {
    for (const CellShape shape : {CellShape::affine, CellShape::curved}) {
      std::vector<PetscInt> cells;
      for (PetscInt c = 0; c < layout.num_local_cells; ++c) {
        const bool affine = layout.cell_is_affine[c] != 0;
        if (body_of_cell[c] == static_cast<int>(body) && affine == (shape == CellShape::affine)) cells.push_back(c);
      }
      if (cells.empty()) continue;
      groups.push_back(make_group<Order>(layout, pattern, static_cast<int>(body), shape, degree_of_body[body], cells));
    }
  }
  return groups;
}

template CellGroups<1> make_cell_groups<1>(const NodeLayout&, const BlockPattern&, const std::vector<int>&,
                                           const std::vector<int>&);
template CellGroups<2> make_cell_groups<2>(const NodeLayout&, const BlockPattern&, const std::vector<int>&,
                                           const std::vector<int>&);

}  // namespace pliant
