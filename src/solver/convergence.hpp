/// When an iterate of Newton's method is a solution.
#pragma once

#include "petsc/handle.hpp"
#include "solver/iteration_start.hpp"
#include "solver/objective.hpp"
#include "solver/statistics.hpp"

#include <algorithm>
#include <functional>

namespace pliant {

struct NewtonOptions {
  double relative =
      1e-8;  ///< residual over the sum of the norms of the forces that balance at the stage's starting guess
  double absolute = 0.0;  ///< residual [N]
  int max_iterations = 50;
};

/// Compares the residual (out-of-balance force) with the forces that must balance: those at the guess, and those at the
/// iterate where they are much less, since a guess may be stretched, or near a wall. A residual made of rounding
/// errors, which cannot fall further, is a solution too.
///
/// Invariants:
/// - The target is known from `measure_guess` on; within a run it only falls.
/// - Every stop at rounding errors is counted, with what it leaves of the forces.
class Convergence {
 public:
  enum class Verdict { iterating, not_a_number, converged, at_rounding };

  /// `reassemble` assembles the Hessian at a point, which the equation's rounding floor rests on. The references
  /// outlive the object.
  Convergence(Objective& objective, const NewtonOptions& options, SolverStatistics& statistics,
              std::function<void(Vec)> reassemble);

  void begin_stage();
  /// Takes the forces at the guess of the stage as those that must balance. Collective.
  void measure_guess(Vec q);
  /// Takes the forces at another point, from which a run starts. Collective.
  void measure(Vec q) { scale_ = objective_.equation().force_scale(q); }
  /// Back to those at the guess of the stage.
  void use_scale_of_guess() { scale_ = first_scale_; }
  /// The runs of this stage start at a solution for other coefficients: it may be one already, but for rounding errors.
  void expect_solution() { starts_at_solution_ = true; }
  /// A residual that will do although it is no solution [N]; 0: none.
  void accept(double residual) { intermediate_target_ = residual; }

  /// The residual to be reached [N].
  double target() const { return std::max({options_.relative * scale_, options_.absolute, intermediate_target_}); }
  /// Sum of the norms of the forces that must balance [N].
  double scale() const { return scale_; }

  /// Of the iterate q. `line_search_is_at_rounding`: the line search that led to it found nothing but rounding errors.
  /// Collective.
  Verdict judge(int iteration, double residual, Vec q, bool line_search_is_at_rounding);
  /// Whether q, with this residual and no run of its own, is a solution. Collective.
  bool is_solution(double residual, Vec q);
  /// Whether the run has met the tolerance for the forces of its guess: where no step helps any more, its iterate is as
  /// near to forces that vanish as it can be.
  bool has_met_first_target() const { return num_lowered_ > 0; }
  /// Counts a stop at rounding errors. Collective.
  void count_rounding(double residual, Vec q);

 private:
  bool is_rounding(double residual, Vec q);
  void lower_scale(Vec q);

  Objective& objective_;
  NewtonOptions options_;
  SolverStatistics& statistics_;
  std::function<void(Vec)> reassemble_;
  double scale_ = 0.0;
  double first_scale_ = 0.0;          // of the guess
  double intermediate_target_ = 0.0;  // [N]
  int num_lowered_ = 0;               // times in this run that the scale became that of the iterate
  bool starts_at_solution_ = false;
  IterationStart start_;
};

}  // namespace pliant
