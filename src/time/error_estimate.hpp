/// Estimates the error that a step adds, and compares it with the tolerance.
///
/// A step of order p from y_n to y_{n+1} is compared with the Adams-Moulton formula through the p + 1 newest rates f,
///
///     y_{n+1} - y_n - integral over the step of the polynomial through f_{n+1}, f_n, ..., f_{n+1-p}
///         = y_{n+1} - y(t_{n+1}) + O(dt^(p+2)),
///
/// where y is the motion through y_n. The rates are there already: v, and the acceleration of the last stage if that is
/// the end of the step (stiffly accurate methods). Unlike a scaled embedded difference this is asymptotically the error
/// itself on nonlinear problems too, where dt^(p+1) comes with several elementary differentials, and with changing
/// steps; of multistep formulas it is what the step adds to the error of the motion, not the smaller local truncation
/// error. Source: Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I, III.1.
///
/// While fewer rates are known, after a start, the estimate is of lower order and nearly always too large: the embedded
/// formula's difference if the method has one, else that of the Adams-Moulton formula through the rates there are. At
/// the first step of a multistep method's ramp, backward Euler, nothing is known yet of how the acceleration changes:
/// the estimate is zero for v, and right for q.
///
/// Methods that are not stiffly accurate have no acceleration at the ends of their steps. Theirs is the embedded
/// difference e_n ~ c dt^(p^+1) y^(p^+1) minus that of the previous step, e_n - (dt_n / dt_{n-1})^(p^+1) e_{n-1}, which
/// is of one order more; still too large by orders if the embedded formula is.
#pragma once

#include "time/stepper.hpp"

#include <memory>
#include <vector>

namespace pliant {

enum class ErrorEstimate { none, local };

/// Estimates the errors of successive attempts. Remembers accelerations of accepted steps; an attempt leaves no trace
/// unless it is accepted. Memory is allocated once.
class LocalError {
 public:
  /// For steps of `method`, and of the methods that start it. Vectors are made like `like`. Collective.
  LocalError(const Method& method, std::shared_ptr<const ConfigurationSpace> space, const StateView& like);

  /// How many past states it needs in the history.
  int num_states() const { return num_rates_ - 1; }
  /// Adds the estimate to a converged attempt that `stepper` has just made. Collective.
  void estimate(const History& history, const Stepper& stepper, StepAttempt& attempt);
  /// The attempt was accepted. Collective.
  void accept(const StepAttempt& attempt);
  /// Discards the past, which says nothing about what follows (at an event).
  void restart();
  /// Collective.
  void keep(Archive& archive);

 private:
  void compare(const History& history, StepAttempt& attempt, int num_rates_q, int num_rates_v);
  void difference_embedded(const Stepper& stepper, StepAttempt& attempt, double dt);
  Vec rate_of_coordinates(const History& history, const StepAttempt& attempt, int r);

  int num_rates_ = 0;  // of a full estimate
  std::shared_ptr<const ConfigurationSpace> space_;
  Handle<Vec> q_, v_;                       // the estimate
  std::vector<Handle<Vec>> accelerations_;  // of accepted states, newest first
  int num_accelerations_ = 0;
  // Methods that are not stiffly accurate: embedded differences of the attempt and of the last accepted step.
  struct EmbeddedDifference {
    Handle<Vec> q, v;
    double dt = 0.0;  // of the step; 0: unknown
  };
  EmbeddedDifference tried_, accepted_;
  std::vector<double> nodes_, weights_;
  std::vector<Vec> rates_;
  // Only for problems with a space: coordinates, the change of their rate, and the rates.
  Handle<Vec> xi_, change_;
  std::vector<Handle<Vec>> charted_;
};

struct Tolerances {
  double relative = 0.0;           ///< relative to the largest |q| and |v| so far
  double absolute = 0.0;           ///< [m]
  double absolute_velocity = 0.0;  ///< [m/s]
};

/// Size of an estimated error in units of the tolerances: the larger of those of q and v,
///
///     |error|_rms / (absolute + relative max |y|_rms),
///
/// where |.|_rms is the root mean square over all entries and max is taken over the accepted states and the attempt.
class ErrorNorm {
 public:
  /// Collective.
  ErrorNorm(const Tolerances& tolerances, const StateView& initial);
  /// The error of an attempt with an estimate. Collective.
  double operator()(const StepAttempt& attempt) const;
  /// The attempt was accepted. Collective.
  void accept(const StepAttempt& attempt);
  void keep(Archive& archive);

 private:
  Tolerances tolerances_;
  double largest_q_ = 0.0, largest_v_ = 0.0;  // rms
};

}  // namespace pliant
