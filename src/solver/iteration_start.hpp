/// Where an iteration started, by which a residual is told from rounding errors.
#pragma once

namespace pliant {

struct IterationStart {
  double residual = 0.0;  ///< [N]
  double size = 0.0;      ///< norm of the unknowns

  /// Whether a residual below its rounding floor, at unknowns of a size, is made of rounding errors. A body that
  /// nothing holds drifts until its rounding errors are as large as its load. The floor goes with the size of the
  /// solution: at the start it must have been as high.
  bool allows_rounding(double residual_now, double floor, double size_now) const {
    return residual_now <= 0.1 * residual || residual * size_now <= floor * size;
  }
};

}  // namespace pliant
