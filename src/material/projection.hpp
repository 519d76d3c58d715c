/// The nearest positive-semidefinite tangent, for Newton steps where the Hessian is indefinite.
#pragma once

#include "material/law.hpp"

namespace pliant {

/// Replaces every eigenvalue of the 9x9 tangent below `floor` [Pa] (>= 0) by `floor`, which gives the nearest such
/// tangent in the Frobenius norm. A tangent without such eigenvalues, or one that is not finite, does not change by a
/// bit. By Jacobi's method for all lanes at once, in the principal directions of the displacement gradient H: those of
/// an isotropic law leave a block of three rows and three of two (Smith, de Goes & Kim 2019); any other law takes
/// more rotations.
void project_to_positive_semidefinite(Tangent<Pack>& A, const Tensor3<Pack>& H, double floor = 0.0);

/// Likewise for a symmetric 10x10 matrix, a tangent bordered by one more variable, with the floor 0.
void project_to_positive_semidefinite(std::array<Pack, 100>& M);

/// Likewise for a symmetric 3x3 tensor, with the floor 0.
void project_to_positive_semidefinite(Tensor3<Pack>& S);

}  // namespace pliant
