/// Time integrals of rates that are given as formulas.
#pragma once

#include "base/expression.hpp"

#include <vector>

namespace pliant {

/// int_0^t f(0, 0, 0, s) ds by adaptive Simpson quadrature, bisected until its error is below 1e-13 of the panel's
/// largest |f|. Sums over whole panels are cached.
class TimeIntegral {
 public:
  /// The integral of the zero function.
  TimeIntegral() = default;
  /// `panel`: an interval [s] not much longer than the formula's features, e.g. a time step. Sums are cached up to
  /// `end` [s].
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
