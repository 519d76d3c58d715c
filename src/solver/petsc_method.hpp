/// PETSc's integrators that users can select, and the equations that they support.
#pragma once

#include "energy/equation/incremental_potential.hpp"

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace pliant {

/// One of PETSc's integrators, as users name it.
struct PetscMethod {
  enum class Kind { alpha2, bdf, arkimex };
  Kind kind;
  std::string_view name;         ///< what follows `petsc:`
  std::string_view type;         ///< TSType
  int order;                     ///< order of accuracy in q and v, unless options change it
  std::string_view description;  ///< one line, for lists
};

/// All of them.
std::span<const PetscMethod> petsc_methods();

/// The integrator `petsc:NAME`; nullptr if there is none.
const PetscMethod* find_petsc_method(std::string_view name);

/// Why TS cannot solve the equation of these terms, in a message for the user; nullopt if it can. Collective.
std::optional<std::string> why_not(const IncrementalPotential& potential);

}  // namespace pliant
