/// The start of an iteration, which distinguishes a residual from rounding errors.
#pragma once

namespace pliant {

struct IterationStart {
  double residual = 0.0;  ///< [N]
  double size = 0.0;      ///< norm of the unknowns

  /// Whether a residual below its rounding floor, at unknowns of norm `size_now`, consists of rounding errors. An
  /// unsupported body drifts until its rounding errors are as large as its load. The floor is proportional to the norm
  /// of the unknowns; scaled to the norm at the start, it must still exceed the residual.
  bool allows_rounding(double residual_now, double floor, double size_now) const {
    return residual_now <= 0.1 * residual || residual * size_now <= floor * size;
  }
};

}  // namespace pliant
