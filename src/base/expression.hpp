/// Formulas in x, y, z, t, as users write them.
#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace pliant {

struct TimeJet;

/// What is wrong with a formula's text; `what()` says it in plain words, `position()` counts characters from 0.
class ExpressionError : public std::runtime_error {
 public:
  ExpressionError(const std::string& message, int position) : std::runtime_error(message), position_(position) {}
  int position() const { return position_; }

 private:
  int position_;
};

/// A formula of the reference position x, y, z [m] and time t [s], evaluated by muParser; the constant `pi` is known.
/// Copies are independent. Default: the constant 0.
class Expression {
 public:
  Expression();
  explicit Expression(double constant);
  /// `factor` multiplies the formula's value (units). Throws ExpressionError.
  explicit Expression(const std::string& text, double factor = 1.0);
  Expression(const Expression& other);
  Expression& operator=(const Expression& other);
  Expression(Expression&&) noexcept;
  Expression& operator=(Expression&&) noexcept;
  ~Expression();

  /// May return inf or NaN where the formula does.
  double operator()(double x, double y, double z, double t) const;
  /// The value, and its derivatives in time, which are exact but for rounding. Where the formula has a kink or a jump,
  /// they are those of the side on which the time `side`, near t, lies.
  TimeJet derivatives(double x, double y, double z, double t, double side) const;
  /// Times in (0, end) at which the formula, its rate or its acceleration jumps (by `min`, `max`, `abs`, `sign`,
  /// `rint`, comparisons, `? :`), ascending; not those that depend on the place. Found where the formula takes other
  /// branches at one of the times k * interval than at the next, and where something linear in t takes another: what
  /// lasts for less than the interval may be missed if it is not.
  std::vector<double> kinks(double end, double interval) const;
  /// Those at X that depend on the place.
  std::vector<double> kinks_at(const std::array<double, 3>& X, double end, double interval) const;
  bool depends_on_space() const;
  bool depends_on_time() const;
  bool is_zero() const;  ///< the constant 0
  /// As written, without the factor; a constant is printed in full precision.
  std::string text() const;

 private:
  struct Formula;
  double constant_ = 0.0;
  std::unique_ptr<Formula> formula_;  // none: constant
};

}  // namespace pliant
