#include "energy/volume/affine_bodies.hpp"

#include "petsc/collective.hpp"

#include <limits>

namespace pliant {

void add_affine_bodies(const NodeLayout& layout, const BlockPattern& pattern, const std::vector<int>& body_of_cell,
                       std::span<const AffineBody> bodies, MassMatrix& mass) {
  for (const AffineBody& body : bodies) {
    // The same cell on all ranks; those that own one of its nodes have it.
    std::int64_t mine = std::numeric_limits<std::int64_t>::max();
    PetscInt cell = -1;
    for (PetscInt c = 0; c < layout.num_local_cells; ++c) {
      const auto k = static_cast<std::size_t>(c);
      if (body_of_cell[k] != body.body || layout.cell_numbers[k] >= mine) continue;
      mine = layout.cell_numbers[k];
      cell = c;
    }
    std::int64_t first = mine;
    check_mpi(MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT64_T, MPI_MIN, layout.comm));
    if (cell < 0 || mine != first) continue;
    const auto corners = layout.nodes_of_cell(cell).first(4);
    const Vector3<double> X = layout.position(corners[0]);
    std::array<Vector3<double>, 3> edges;
    for (std::size_t k = 0; k < 3; ++k) edges[k] = Vector3<double>(layout.position(corners[k + 1])) - X;
    const double volume = dot(edges[0], cross(edges[1], edges[2]));
    std::array<Vector3<double>, 4> gradients{};
    std::array<double, 4> at_centre{1.0};
    for (std::size_t k = 0; k < 3; ++k) {
      gradients[k + 1] = (1.0 / volume) * cross(edges[(k + 1) % 3], edges[(k + 2) % 3]);
      gradients[0] = gradients[0] - gradients[k + 1];
      at_centre[k + 1] = dot(gradients[k + 1], body.centre - X);
      at_centre[0] -= at_centre[k + 1];
    }
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
