/// What the input says about the solver of a stage.
#pragma once

#include "input/config.hpp"
#include "model/model.hpp"
#include "petsc/check.hpp"
#include "solver/convergence.hpp"
#include "solver/linear_kind.hpp"

#include <string>

namespace pliant {

NewtonOptions newton_options(const Config& config, const Model& model);

/// The linear solver that the input asks for, or the automatic choice.
LinearKind linear_kind(const Config& config, Model& model);

/// A description of the solver for the log.
std::string description_of_solver(const Config& config, Model& model);

/// PETSc reads its options here, the same on every rank, so that all fail together.
template <class Make>
auto with_user_options(const Make& make) {
  try {
    return make();
  } catch (const PetscFailure& failure) {
    if (failure.code() == PETSC_ERR_MEM) throw;
    throw InputError({"PETSc options", 0, 0}, failure.what());
  }
}

}  // namespace pliant
