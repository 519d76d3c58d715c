#include "solver/linear_kind.hpp"

#include <fmt/format.h>

namespace pliant {
namespace {

/// Beyond this many unknowns the fill of a factorization costs more time and memory (about 1.6 GB here) than the
/// iterations of CG + GAMG. Measured up to 84,000, where the factorization was still faster.
constexpr PetscInt max_unknowns_of_factorization = 150000;

}  // namespace

LinearKind automatic_linear_kind(PetscInt num_unknowns, int order) {
  if (num_unknowns <= max_unknowns_of_factorization) return LinearKind::cholesky;
  return order == 1 ? LinearKind::amg : LinearKind::p_multigrid;
}

std::string describe(LinearKind kind, Symmetry symmetry) {
  const std::string krylov = symmetry == Symmetry::symmetric ? "conjugate gradients" : "GMRES";
  if (kind != LinearKind::cholesky && symmetry == Symmetry::indefinite) {
    return krylov + " with algebraic multigrid (GAMG) for displacements, Schur complement for pressures";
  }
  if (kind == LinearKind::amg) return krylov + " with algebraic multigrid (GAMG)";
  if (kind == LinearKind::p_multigrid) {
    return krylov +
           " with p-multigrid (quadratic elements, then linear ones by a factorization, or GAMG if they are many)";
  }
  const char* factors = symmetry == Symmetry::unsymmetric        ? "LU factorization"
                        : symmetry == Symmetry::nearly_symmetric ? "LDL^T factorization of the symmetric part"
                                                                 : "LDL^T factorization";
  return fmt::format("{} preconditioned by a MUMPS {} in {} precision, kept while it pays", krylov, factors,
                     symmetry == Symmetry::indefinite ? "double" : "single");
}

}  // namespace pliant
