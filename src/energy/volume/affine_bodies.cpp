#include "energy/volume/affine_bodies.hpp"

#include "fem/straight_cell.hpp"

#include <optional>

namespace pliant {
namespace {

/// The corners of a body's largest cell, whose linear shape functions N describe its motion.
struct CornersOfBody {
  std::span<const PetscInt> nodes;
  std::array<Vector3<double>, 4> gradients;
  std::array<double, 4> at_centre{};  // N_a(c)
};

/// Nothing on ranks without the cell. Collective.
std::optional<CornersOfBody> corners_of(const NodeLayout& layout, const std::vector<int>& body_of_cell,
                                        const AffineBody& body) {
  const PetscInt cell = largest_cell_of(layout, body_of_cell, body.body);
  if (cell < 0) return std::nullopt;
  CornersOfBody corners{layout.nodes_of_cell(cell).first(4), {}, {1.0, 0.0, 0.0, 0.0}};
  std::array<Vector3<double>, 4> X;
  for (std::size_t a = 0; a < 4; ++a) X[a] = layout.position(corners.nodes[a]);
  corners.gradients = linear_gradients(X);
  for (std::size_t a = 0; a < 4; ++a) corners.at_centre[a] += dot(corners.gradients[a], body.centre - X[0]);
  return corners;
}

}  // namespace

void add_affine_bodies(const NodeLayout& layout, const BlockPattern& pattern, const std::vector<int>& body_of_cell,
                       std::span<const AffineBody> bodies, MassMatrix& mass) {
  for (const AffineBody& body : bodies) {
    const auto corners = corners_of(layout, body_of_cell, body);
    if (!corners) continue;
    const auto& [nodes, gradients, at_centre] = *corners;
    for (std::size_t a = 0; a < 4; ++a) {
      if (nodes[a] >= layout.num_owned_nodes) continue;
      for (std::size_t b = 0; b < 4; ++b) {
        mass.add(pattern.block(nodes[a], nodes[b]),
                 body.mass * at_centre[a] * at_centre[b] + dot(gradients[a], matvec(body.second_moment, gradients[b])));
      }
    }
  }
}

std::vector<MassAtNode> masses_of_affine_bodies(const NodeLayout& layout, const std::vector<int>& body_of_cell,
                                                std::span<const AffineBody> bodies) {
  std::vector<MassAtNode> result;
  for (const AffineBody& body : bodies) {
    const auto corners = corners_of(layout, body_of_cell, body);
    if (!corners) continue;
    for (std::size_t a = 0; a < 4; ++a) {
      if (corners->nodes[a] >= layout.num_owned_nodes) continue;
      result.push_back({corners->nodes[a], body.mass * corners->at_centre[a], body.centre});
    }
  }
  return result;
}

}  // namespace pliant
