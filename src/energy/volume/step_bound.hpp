/// How far a displacement may go before a tetrahedron is inverted.
#pragma once

#include "base/simd.hpp"
#include "base/tensor.hpp"

namespace pliant {

/// The smallest alpha in (0, 1] with det(F + alpha dF) = 0, or +inf if there is none. det F > 0.
double first_inversion(const Tensor3<double>& F, const Tensor3<double>& dF);

/// False only if det(F + alpha dF) > 0 for certain on [0, 1]; lane by lane.
PLIANT_INLINE bool may_invert(const Tensor3<Pack>& F, const Tensor3<Pack>& dF) {
  const auto magnitude = [](const Pack& x) { return std::experimental::abs(x); };
  const Pack lowest = det(F) - magnitude(dot(cofactor(F), dF)) - magnitude(dot(F, cofactor(dF))) - magnitude(det(dF));
  return any_of(!(lowest > 0.0));
}

}  // namespace pliant
