/// Eigenvalues and eigenvectors of a pair of sparse symmetric matrices: the modes of a vibrating body.
#pragma once

#include "petsc/handle.hpp"

#include <string>
#include <vector>

namespace pliant {

/// K x = lambda M x, K symmetric, M symmetric and positive semidefinite: stiffness and mass.
struct EigenProblem {
  Mat K = nullptr;
  Mat M = nullptr;
  /// Negative eigenvalues of K on the null space of M, as a saddle point has one for each of its multipliers: they
  /// belong to no motion.
  PetscInt num_negative = 0;
};

struct Eigenpairs {
  std::vector<double> values;        ///< ascending [1/s^2]
  std::vector<Handle<Vec>> vectors;  ///< of each, x . M x = 1
  /// The size of rounding errors in each of them: what is smaller may be zero [1/s^2].
  std::vector<double> roundings;
};

/// The smallest eigenvalues, negative ones first, fewer if M has a lower rank. By Krylov-Schur iteration on
/// (K - sigma M)^-1 M, with the factorization by MUMPS at a shift sigma below all eigenvalues, which it proves by its
/// inertia (Sylvester's law). Throws SolveError if K - sigma M is singular for every shift, if memory is too small, or
/// if the iteration does not converge. Options of SLEPc (-eps_...) override. Collective.
Eigenpairs smallest_eigenpairs(const EigenProblem& problem, PetscInt number);

/// Likewise, those nearest to `target` [1/s^2].
Eigenpairs nearest_eigenpairs(const EigenProblem& problem, PetscInt number, double target);

/// The version of SLEPc.
std::string slepc_version();

}  // namespace pliant
