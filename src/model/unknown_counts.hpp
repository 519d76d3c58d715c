/// How many unknowns (degrees of freedom) the displacements of a model are, for people.
#pragma once

#include "model/model.hpp"

namespace pliant {

/// Prescribed ones included. Apexes of free shells stand for none.
struct UnknownCounts {
  PetscInt64 mine = 0;  ///< of the nodes that this rank owns
  PetscInt64 all = 0, prescribed = 0;
};

/// Collective.
UnknownCounts count_unknowns(const Config& config, const Model& model);

}  // namespace pliant
