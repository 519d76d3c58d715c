/// The numbering of the pressures of mixed elements: at the vertices, once for each body that meets there.
#pragma once

#include "fem/layout.hpp"

#include <vector>

namespace pliant {

/// A rank owns the pressures at the vertices it owns; local numbers 0 .. num_owned-1 are owned, the ghosts follow in
/// ascending global number. Every local cell finds all of its pressures.
struct PressureLayout {
  PetscInt num_owned = 0;
  PetscInt num_local = 0;
  PetscInt first_global = 0;
  PetscInt num_global = 0;
  std::vector<PetscInt> ghost_globals;         ///< of local pressures num_owned ..., ascending
  std::vector<std::vector<PetscInt>> of_node;  ///< [body][local node]: local pressure, -1 if none
};

/// `body_of_cell`: per local cell; negative: it has no pressure. Collective.
PressureLayout make_pressure_layout(const NodeLayout& layout, const std::vector<int>& body_of_cell, int num_bodies);

/// A vector of the pressures with ghosts (petsc/ghosted.hpp), zero. Collective.
Handle<Vec> make_vector(const PressureLayout& pressures, MPI_Comm comm);

}  // namespace pliant
