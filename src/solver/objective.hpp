/// What Newton's method currently solves: the equation of a stage, and the function that measures an iterate.
#pragma once

#include "energy/stage_equation.hpp"
#include "petsc/work_vector.hpp"
#include "solver/merit.hpp"
#include "solver/proximal.hpp"
#include "solver/statistics.hpp"

namespace pliant {

/// What a run of Newton's method looks for, which determines the function that its line search lowers.
enum class Aim {
  minimum,         ///< of the potential
  root,            ///< of the residual, by steps that lower a merit function of it
  whole_steps,     ///< of the residual, by whole steps whether or not they lower it
  descent,         ///< the same, by steps along which the forces do work, with projected Hessians
  any_equilibrium  ///< a root of the gradient of a potential, whatever the signs of the Hessian's eigenvalues
};

/// The equation of the stage, with a proximal term if a solution is to be held near a point, and the measure of an
/// iterate: the potential if the aim is a minimum, otherwise a merit function of the residual. All methods are
/// collective unless they only read.
///
/// Invariants:
/// - The aim suits the stage's equation: `minimum` and `any_equilibrium` need a potential, or at least a
///   symmetric Hessian.
/// - This object owns the vector from which the equation extrapolates stresses, and the equation may refer to it.
class Objective {
 public:
  /// The references outlive the object.
  Objective(StageEquation& equation, SolverStatistics& statistics);

  StageEquation& equation() const { return equation_; }

  /// Begins a stage, with the aim that suits the equation and without a scale of its merit function.
  void begin_stage(const StagePoint& stage);
  /// Where the stage starts from.
  Vec start() const { return start_; }
  bool is_static() const { return is_static_; }

  Aim aim() const { return aim_; }
  void set_aim(Aim aim) { aim_ = aim; }
  /// The aim that usually suits the equation: a minimum if there is a potential, otherwise a root.
  Aim usual_aim() const { return usual_aim_; }
  bool is_minimised() const { return aim_ == Aim::minimum; }

  /// The potential at q [J]; +inf beyond a barrier.
  double value(Vec q);
  void gradient(Vec q, Vec r);
  void hessian(Vec q, Mat K, Projection projection);
  /// The function to be lowered: the potential at q, or the merit of the residual there [J].
  double measure(Vec q);

  const Merit& merit() const { return merit_; }
  /// Discards the scale of the merit function, which no longer fits the problem: the next Hessian sets it.
  void forget_scale_of_merit() { merit_has_scale_ = false; }
  /// Discards it for guesses as well, which are compared before there is a Hessian. Collective.
  void forget() {
    merit_.forget_scale();
    merit_has_scale_ = false;
  }
  /// Takes the scale from K unless there is one, or no merit is needed.
  void scale_merit(Mat K);

  /// Sets q = `to`, the end of a straight step from q.
  void move(Vec q, Vec to);

  Proximal& proximal() { return proximal_; }

 private:
  StageEquation& equation_;
  SolverStatistics& statistics_;
  WorkVector r_, before_, diagonal_;
  Merit merit_;
  Proximal proximal_;
  Vec start_ = nullptr;
  Aim aim_ = Aim::minimum, usual_aim_ = Aim::minimum;
  bool is_static_ = false;
  bool merit_has_scale_ = false;
};

}  // namespace pliant
