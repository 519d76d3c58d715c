#include "model/initial_displacement.hpp"

namespace pliant {

std::vector<double> initial_displacement(const VectorExpression& formula, const NodeLayout& layout) {
  std::vector<double> u(layout.coordinates.size());
  for (PetscInt node = 0; node < layout.num_local_nodes; ++node) {
    const auto [x, y, z] = layout.position(node);
    for (std::size_t i = 0; i < 3; ++i) u[3 * node + i] = formula[i](x, y, z, 0.0);
  }
  return u;
}

}  // namespace pliant
