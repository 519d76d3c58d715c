#include "solver/linear_kind.hpp"

#include <fmt/format.h>

namespace pliant {
namespace {

/// Beyond this many unknowns the fill of a factorization costs so much time and memory (about 1.6 GB here) that it is
/// not tried.
constexpr PetscInt max_unknowns_of_factorization = 150000;
/// From this many unknowns on, multigrid is tried first.
constexpr PetscInt min_unknowns_of_multigrid = 10000;

}  // namespace

LinearKind automatic_linear_kind(PetscInt num_unknowns, int order, bool may_adapt) {
  if (num_unknowns <= max_unknowns_of_factorization) {
    const bool adapts = may_adapt && num_unknowns >= min_unknowns_of_multigrid;
    return adapts ? LinearKind::adaptive : LinearKind::cholesky;
  }
  return order == 1 ? LinearKind::amg : LinearKind::p_multigrid;
}

std::string describe(LinearKind kind, Symmetry symmetry) {
  const std::string krylov = symmetry == Symmetry::symmetric          ? "conjugate gradients"
                             : symmetry == Symmetry::nearly_symmetric ? "conjugate gradients or GMRES"
                                                                      : "GMRES";
  constexpr const char* multigrid = "algebraic multigrid (smoothed aggregation in single precision)";
  if (kind == LinearKind::adaptive) {
    return fmt::format("{} with {}, or a MUMPS LDL^T factorization where that takes less time", krylov, multigrid);
  }
  if (kind != LinearKind::cholesky && symmetry == Symmetry::indefinite) {
    return krylov + " with algebraic multigrid (GAMG) for displacements, Schur complement for pressures";
  }
  if (kind == LinearKind::amg) return fmt::format("{} with {}", krylov, multigrid);
  if (kind == LinearKind::p_multigrid) {
    return krylov +
           " with p-multigrid (quadratic elements, linear ones, then smoothed aggregation, in single precision)";
  }
  const char* factors = symmetry == Symmetry::unsymmetric        ? "LU factorization"
                        : symmetry == Symmetry::nearly_symmetric ? "LDL^T factorization of the symmetric part"
                                                                 : "LDL^T factorization";
  return fmt::format("{} preconditioned by a MUMPS {} in {} precision, kept while it pays", krylov, factors,
                     symmetry == Symmetry::indefinite ? "double" : "single");
}

}  // namespace pliant
