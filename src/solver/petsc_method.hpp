/// The integrators of PETSc that users can name, and the equations for which they can.
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
  int order;                     ///< in q and v, unless options change it
  std::string_view description;  ///< one line, for lists
};

/// All of them.
std::span<const PetscMethod> petsc_methods();

/// That of `petsc:NAME`; nullptr if there is none.
const PetscMethod* find_petsc_method(std::string_view name);

/// Why TS cannot solve the equation of these terms, for the user; nothing if it can. Collective.
std::optional<std::string> why_not(const IncrementalPotential& potential);

}  // namespace pliant
