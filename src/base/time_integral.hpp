/// Integrals over time of rates that are given as formulas.
#pragma once

#include "base/expression.hpp"

#include <vector>

namespace pliant {

/// int_0^t f(0, 0, 0, s) ds by Simpson's rule, halved until its error is below 1e-13 of the panel's largest |f|. What
/// was summed up over whole panels is kept.
class TimeIntegral {
 public:
  /// The integral of 0.
  TimeIntegral() = default;
  /// `panel`: which the formula's features are not much shorter than, e.g. a time step [s]; sums are kept up to `end`
  /// [s].
  TimeIntegral(Expression rate, double end, double panel);

  /// May be inf or NaN where the formula is.
  double operator()(double t) const;
  bool is_zero() const { return rate_.is_zero(); }

 private:
  Expression rate_;
  double panel_ = 1.0;
  std::vector<double> totals_{0.0};  // at the ends of panels, from 0
};

}  // namespace pliant
