/// The range of wave speeds of the materials, for warnings.
#pragma once

#include "input/elasticity.hpp"

#include <algorithm>
#include <cmath>

namespace pliant {

struct WaveSpeeds {
  double fastest = 0.0;  ///< pressure waves of the stiffest body [m/s]
  double slowest = 0.0;  ///< shear waves of the softest body [m/s]

  /// Widens the range by the waves of a law with the density [kg/m^3]; a body without mass has none.
  void include(const WaveModuli& moduli, double density) {
    if (density <= 0.0) return;
    // An incompressible body has shear waves only.
    const double largest = std::isfinite(moduli.largest) ? moduli.largest : moduli.smallest;
    fastest = std::max(fastest, std::sqrt(largest / density));
    slowest = std::min(slowest, std::sqrt(moduli.smallest / density));
  }
};

}  // namespace pliant
