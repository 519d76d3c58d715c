/// Whether a fitted law is stable where it was measured.
#pragma once

#include "study/fit_material.hpp"
#include "study/fit_tests.hpp"

#include <span>
#include <string>
#include <vector>

namespace pliant {

/// One loading over a range of stretches, and where the law first fails in it, going out from rest.
struct StabilityRange {
  Loading loading;
  double lowest, highest;             ///< stretches (amounts) that were looked at
  bool is_measured;                   ///< by a test of this loading; others are looked at up to the same I1
  std::vector<std::string> failures;  ///< in words, with the stretch; empty: stable
};

/// Looks at the measured ranges of the loadings, and at uniaxial, equibiaxial and pure shear loading up to the largest
/// I1 that any test has reached:
///   stress rises       the nominal stress grows with the stretch
///   Drucker            d tau_i d(ln l_i) > 0 for the principal Kirchhoff stresses and stretches: the second derivative
///                      of the energy in the logarithmic stretches is positive definite (at J = 1 if incompressible)
///   Baker-Ericksen     the larger principal stress goes with the larger stretch
/// Sources: Drucker, J. Appl. Mech. 26 (1959) 101-106; Baker & Ericksen, J. Wash. Acad. Sci. 44 (1954) 33-35.
std::vector<StabilityRange> stability_of(const FitMaterial& material, std::span<const double> all,
                                         std::span<const MaterialTest> tests);

/// A message if the law is unstable at rest; empty if it is not.
std::string instability_at_rest(const FitMaterial& material, std::span<const double> all);

}  // namespace pliant
