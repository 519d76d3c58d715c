/// What contact uses where the input gives no numbers, at obstacles and between bodies.
#pragma once

#include <algorithm>

namespace pliant {

/// A spring of 10 Young's moduli per facet deforms by a tenth of what an element does, and is as stiff as ten of them,
/// which neither a factorization nor Newton's method notices. E is 2 to 3 shear moduli.
inline constexpr double shear_moduli_per_facet = 30.0;
/// Fraction of the size of a facet by which the rounding of the kink moves the body, or at which a barrier begins.
inline constexpr double width_per_facet = 1.0 / 50.0;
/// A surface that is less deep than this fraction of the width only touches, and is not pushed.
inline constexpr double least_push = 1e-6;

/// The shear modulus that contact goes by: what is thinner than its facets, of a size [m], gives way like a softer
/// solid.
inline double contact_modulus(double shear_modulus, double thickness, double size) {
  return thickness > 0.0 ? shear_modulus * std::min(1.0, thickness / size) : shear_modulus;
}

}  // namespace pliant
