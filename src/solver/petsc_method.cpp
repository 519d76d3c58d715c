#include "solver/petsc_method.hpp"

#include "petsc/collective.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <petscts.h>

namespace pliant {
namespace {

constexpr std::array<PetscMethod, 3> methods_of_petsc{{
    {PetscMethod::Kind::alpha2, "alpha2", TSALPHA2, 2,
     "generalized-alpha; -ts_alpha_radius 1 (the default, no damping: the implicit midpoint rule) to 0"},
    {PetscMethod::Kind::bdf, "bdf", TSBDF, 2, "backward differentiation; -ts_bdf_order 1 to 6"},
    {PetscMethod::Kind::arkimex, "arkimex", TSARKIMEX, 3,
     "diagonally implicit Runge-Kutta, the implicit part of an additive method; -ts_arkimex_type 2e, 3, 4, 5, ..."},
}};

}  // namespace

std::span<const PetscMethod> petsc_methods() {
  return methods_of_petsc;
}

const PetscMethod* find_petsc_method(std::string_view name) {
  constexpr std::string_view prefix = "petsc:";
  if (!name.starts_with(prefix)) return nullptr;
  const auto found = std::ranges::find(methods_of_petsc, name.substr(prefix.size()), &PetscMethod::name);
  return found == methods_of_petsc.end() ? nullptr : &*found;
}

std::optional<std::string> why_not(const IncrementalPotential& potential) {
  bool has_inertia = false;
  for (const EnergyTerm* term : potential.terms()) {
    has_inertia = has_inertia || term->declaration().account == Account::kinetic;
    if (term->declaration().has_frozen_coefficients || term->declaration().refreezes) {
      return fmt::format("the term `{}` freezes coefficients in every stage, which PETSc's integrators do not support",
                         term->name());
    }
    if (function_of_sum(term->coupling()) != nullptr) {
      return fmt::format(
          "the term `{}` couples all its unknowns with one another, for which PETSc would assemble a dense matrix",
          term->name());
    }
    if (any_rank(potential.comm(), term->num_internal() > 0)) {
      return fmt::format("the term `{}` has internal variables, which PETSc's integrators do not advance",
                         term->name());
    }
  }
  if (!has_inertia) return "without inertia there is no equation of motion to integrate in time";
  return std::nullopt;
}

}  // namespace pliant
