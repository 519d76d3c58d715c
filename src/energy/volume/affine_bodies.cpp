#include "energy/volume/affine_bodies.hpp"

#include "fem/straight_cell.hpp"

namespace pliant {

void add_affine_bodies(const NodeLayout& layout, const BlockPattern& pattern, const std::vector<int>& body_of_cell,
                       std::span<const AffineBody> bodies, MassMatrix& mass) {
  for (const AffineBody& body : bodies) {
    const PetscInt cell = first_cell_of(layout, body_of_cell, body.body);
    if (cell < 0) continue;
    const auto corners = layout.nodes_of_cell(cell).first(4);
    std::array<Vector3<double>, 4> X;
    for (std::size_t a = 0; a < 4; ++a) X[a] = layout.position(corners[a]);
    const auto gradients = linear_gradients(X);
    std::array<double, 4> at_centre{1.0, 0.0, 0.0, 0.0};  // N_a(c)
    for (std::size_t a = 0; a < 4; ++a) at_centre[a] += dot(gradients[a], body.centre - X[0]);
    for (std::size_t a = 0; a < 4; ++a) {
      if (corners[a] >= layout.num_owned_nodes) continue;
      for (std::size_t b = 0; b < 4; ++b) {
        mass.add(pattern.block(corners[a], corners[b]),
                 body.mass * at_centre[a] * at_centre[b] + dot(gradients[a], matvec(body.second_moment, gradients[b])));
      }
    }
  }
}

}  // namespace pliant
