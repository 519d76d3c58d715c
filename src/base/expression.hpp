/// Formulas in x, y, z and t, as users write them.
#pragma once

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace pliant {

struct TimeJet;

/// An error in a formula's text; `what()` describes it, `position()` is its character, counted from 0.
class ExpressionError : public std::runtime_error {
 public:
  ExpressionError(const std::string& message, int position) : std::runtime_error(message), position_(position) {}
  int position() const { return position_; }

 private:
  int position_;
};

/// A formula of the reference position x, y, z [m] and time t [s], evaluated by muParser; the constant `pi` is known.
/// Copies are independent, except that a formula made replaceable is replaced in all copies made since, at once: so
/// what a running simulation has copied from its input can change. Default: the constant 0.
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
  /// The value and its time derivatives, exact to rounding. At a kink or a jump they are one-sided: those of the side
  /// on which the time `side`, near t, lies.
  TimeJet derivatives(double x, double y, double z, double t, double side) const;
  /// Times in (0, end] at which the formula, its rate or its acceleration jumps (by `min`, `max`, `abs`, `sign`,
  /// `rint`, comparisons, `? :`), ascending, without those that depend on the place. Found where the formula takes
  /// another branch at k * interval than at (k + 1) * interval, and where something linear in t changes branch. A
  /// nonlinear feature that lasts for less than the interval may be missed.
  std::vector<double> kinks(double end, double interval) const;
  /// The times at X before the end, of those that depend on the place.
  std::vector<double> kinks_at(const std::array<double, 3>& X, double end, double interval) const;
  bool depends_on_space() const;
  bool depends_on_time() const;
  bool is_zero() const;  ///< the constant 0
  /// This formula times a number; replaceable with it.
  Expression scaled(double factor) const;

  void make_replaceable();
  bool is_replaceable() const { return source_ != nullptr; }
  /// Replaces the formula here and in all copies, however they are scaled. Only of one that is replaceable. `by` may
  /// depend on the position only if the formula of the input does: integration points were chosen for that.
  void replace(const Expression& by) const;
  /// What it is now, not replaceable and without the link to its copies.
  Expression frozen() const;

  /// The formula as written, without the factor; a constant is printed in full precision.
  std::string text() const;

 private:
  struct Formula;
  struct Source;

  /// Takes over what `source_` holds, if that has changed.
  void update() const {
    if (source_ != nullptr) take_over();
  }
  void take_over() const;
  void set(const Expression& from, double factor) const;

  // Mutable: what a replaceable formula was last found to be.
  mutable double constant_ = 0.0;
  mutable std::unique_ptr<Formula> formula_;  // null for a constant
  std::shared_ptr<Source> source_;            // null: not replaceable
  double scale_ = 1.0;                        // of what the source holds
  mutable std::uint64_t version_ = 0;         // of what was taken over
};

}  // namespace pliant
