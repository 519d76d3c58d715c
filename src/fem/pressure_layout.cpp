#include "fem/pressure_layout.hpp"

#include "petsc/array_view.hpp"
#include "petsc/ghosted.hpp"

#include <algorithm>

namespace pliant {

PressureLayout make_pressure_layout(const NodeLayout& layout, const std::vector<int>& body_of_cell, int num_bodies) {
  PressureLayout result;
  auto& of_node = result.of_node;
  of_node.assign(static_cast<std::size_t>(num_bodies),
                 std::vector<PetscInt>(static_cast<std::size_t>(layout.num_local_nodes), -1));
  for (PetscInt c = 0; c < layout.num_local_cells; ++c) {
    if (body_of_cell[c] < 0) continue;
    const auto nodes = layout.nodes_of_cell(c);
    for (int a = 0; a < 4; ++a) of_node[body_of_cell[c]][nodes[a]] = 0;
  }
  // All cells around an owned node are local, so its owner knows all bodies there.
  for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) {
    for (auto& numbers : of_node) {
      if (numbers[n] == 0) numbers[n] = result.num_owned++;
    }
  }
  check_mpi(MPI_Exscan(&result.num_owned, &result.first_global, 1, MPIU_INT, MPI_SUM, layout.comm));
  check_mpi(MPI_Allreduce(&result.num_owned, &result.num_global, 1, MPIU_INT, MPI_SUM, layout.comm));

  // Ghosts receive their global numbers from the owners, as the numbers of a nodal vector.
  std::vector<std::pair<PetscInt, PetscInt*>> ghosts;
  const Handle<Vec> exchange = make_vector(layout);
  for (auto& numbers : of_node) {
    {
      const ArrayView values(exchange.get());
      for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) values[3 * n] = result.first_global + numbers[n];
    }
    update_ghosts(exchange.get());
    const ConstGhostedView values(exchange.get());
    for (PetscInt n = layout.num_owned_nodes; n < layout.num_local_nodes; ++n) {
      if (numbers[n] == 0) ghosts.emplace_back(static_cast<PetscInt>(values.span()[3 * n]), &numbers[n]);
    }
  }
  std::sort(ghosts.begin(), ghosts.end());
  result.num_local = result.num_owned;
  for (const auto& [global, number] : ghosts) {
    *number = result.num_local++;
    result.ghost_globals.push_back(global);
  }
  return result;
}

Handle<Vec> make_vector(const PressureLayout& pressures, MPI_Comm comm) {
  Handle<Vec> v;
  check(VecCreateGhost(comm, pressures.num_owned, PETSC_DECIDE, static_cast<PetscInt>(pressures.ghost_globals.size()),
                       pressures.ghost_globals.data(), v.out()));
  return v;
}

}  // namespace pliant
