/// The derivatives of an isotropic law by its parameters, exact to rounding: the law's own formulas on dual numbers.
#pragma once

#include "base/dual.hpp"
#include "base/tensor.hpp"
#include "material/elastic_law.hpp"

#include <span>

namespace pliant {

/// Whether the functions below know the law: it is isotropic.
bool has_parameter_slopes(const ElasticLawSpec& law);

/// P(H) [Pa] of the law with these parameters in place of its own, and its derivative in their direction.
Tensor3<Dual<double>> dual_stress(const ElasticLawSpec& law, std::span<const Dual<double>> parameters,
                                  const Tensor3<double>& H);

/// Hooke's constants at rest [Pa], likewise.
LameOf<Dual<double>> dual_at_rest(const ElasticLawSpec& law, std::span<const Dual<double>> parameters);

}  // namespace pliant
