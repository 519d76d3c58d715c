#include "model/initial_displacement.hpp"

#include "model/rigid_bodies.hpp"
#include "petsc/array_view.hpp"

namespace pliant {

std::vector<double> initial_displacement(const VectorExpression& formula, const NodeLayout& layout) {
  std::vector<double> u(layout.coordinates.size());
  for (PetscInt node = 0; node < layout.num_local_nodes; ++node) {
    const auto [x, y, z] = layout.position(node);
    for (std::size_t i = 0; i < 3; ++i) u[3 * node + i] = formula[i](x, y, z, 0.0);
  }
  return u;
}

void put_initial_state(const Config& config, const NodeLayout& layout, const std::vector<int>& body_of_cell, Vec q,
                       Vec v) {
  {
    const ArrayView displacement(q), velocity(v);
    for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) {
      const auto [x, y, z] = layout.position(n);
      for (int i = 0; i < 3; ++i) {
        displacement[3 * n + i] = config.initial.displacement[i](x, y, z, 0.0);
        velocity[3 * n + i] = config.initial.velocity[i](x, y, z, 0.0);
      }
    }
  }
  set_velocities_of_rigid_bodies(config, layout, body_of_cell, v);
}

}  // namespace pliant
