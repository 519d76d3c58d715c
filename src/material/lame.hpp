/// Elastic constants of an isotropic solid, and conversions between them.
#pragma once

#include <limits>

namespace pliant {

/// The Lame parameters.
template <class S>
struct LameOf {
  S mu;      ///< shear modulus [Pa]
  S lambda;  ///< first Lame parameter [Pa]
};
using Lame = LameOf<double>;

/// mu = E / (2 (1 + nu)), lambda = E nu / ((1 + nu) (1 - 2 nu)); E [Pa] > 0, -1 < nu <= 1/2.
constexpr Lame lame(double youngs_modulus, double poissons_ratio) {
  return {youngs_modulus / (2.0 * (1.0 + poissons_ratio)),
          youngs_modulus * poissons_ratio / ((1.0 + poissons_ratio) * (1.0 - 2.0 * poissons_ratio))};
}

/// The constants of an incompressible body: lambda is infinite.
constexpr bool is_incompressible(const Lame& c) {
  return c.lambda == std::numeric_limits<double>::infinity();
}

/// E = mu (3 lambda + 2 mu) / (lambda + mu) [Pa].
constexpr double youngs_modulus(const Lame& c) {
  if (is_incompressible(c)) return 3.0 * c.mu;
  return c.mu * (3.0 * c.lambda + 2.0 * c.mu) / (c.lambda + c.mu);
}

/// nu = lambda / (2 (lambda + mu)).
constexpr double poissons_ratio(const Lame& c) {
  if (is_incompressible(c)) return 0.5;
  return 0.5 * c.lambda / (c.lambda + c.mu);
}

/// K = lambda + 2/3 mu [Pa].
constexpr double bulk_modulus(const Lame& c) {
  return c.lambda + 2.0 / 3.0 * c.mu;
}

}  // namespace pliant
