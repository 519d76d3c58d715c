/// Convergence test: decides when an iterate of Newton's method is a solution.
#pragma once

#include "petsc/handle.hpp"
#include "solver/iteration_start.hpp"
#include "solver/objective.hpp"
#include "solver/statistics.hpp"

#include <algorithm>
#include <functional>
#include <limits>

namespace pliant {

/// Whether there are slender bodies, such as rods, which straight steps stretch much more than solutions do.
enum class Slenderness { none, some };

struct NewtonOptions {
  double relative = 1e-8;  ///< residual over the sum of the norms of the forces that balance at the starting guess
  double absolute = 0.0;   ///< residual [N]
  int max_iterations = 50;
  Slenderness slenderness = Slenderness::none;
  /// The largest displacement of an equilibrium without inertia [m]: bodies that move farther are held by nothing.
  double reach = std::numeric_limits<double>::infinity();
};

/// Compares the residual (out-of-balance force) with the forces that must balance. Their scale is taken at the guess,
/// or at the iterate where they are much smaller, because a guess may be overstretched or near a wall. An iterate whose
/// residual consists of rounding errors, and cannot fall further, is a solution too.
///
/// Invariants:
/// - The target is known from `measure_guess` on; within a run it only falls.
/// - Every stop at rounding errors is counted, with its residual relative to the forces.
class Convergence {
 public:
  enum class Verdict { iterating, not_a_number, converged, at_rounding };

  /// `reassemble` assembles the Hessian at a point; the equation's rounding floor depends on it. The references outlive
  /// the object.
  Convergence(Objective& objective, const NewtonOptions& options, SolverStatistics& statistics,
              std::function<void(Vec)> reassemble);

  void begin_stage();
  /// Takes the forces at the guess of the stage as those that must balance. Collective.
  void measure_guess(Vec q);
  /// Takes the forces at another point, from which a run starts, as the scale. Collective.
  void measure(Vec q) { scale_ = objective_.equation().force_scale(q); }
  /// Returns to the forces at the guess of the stage.
  void use_scale_of_guess() { scale_ = first_scale_; }
  /// Declares that the runs of this stage start from a solution for other coefficients, which may already be a solution
  /// up to rounding errors.
  void expect_solution() { starts_at_solution_ = true; }
  /// Sets a residual at which runs may end although it is not yet that of a solution [N]; 0: none.
  void accept(double residual) { intermediate_target_ = residual; }

  /// The residual at which the iteration has converged [N].
  double target() const {
    return std::max({options_.relative * scale_, options_.absolute, intermediate_target_, least_target_});
  }
  /// Sum of the norms of the forces that must balance [N].
  double scale() const { return scale_; }

  /// Judges the iterate q. `line_search_is_at_rounding`: the line search that led to it could not go beyond rounding
  /// errors. Collective.
  Verdict judge(int iteration, double residual, Vec q, bool line_search_is_at_rounding);
  /// Whether q with this residual is a solution without any iteration. Collective.
  bool is_solution(double residual, Vec q);
  /// Whether the run has met the tolerance relative to the forces of its guess. If no step helps any more after that,
  /// the iterate is as close to zero forces as it can be.
  bool has_met_first_target() const { return num_lowered_ > 0; }
  /// Counts a stop at rounding errors. Collective.
  void count_rounding(double residual, Vec q);

 private:
  bool is_rounding(double residual, Vec q);
  /// The norm of the displacements, to which rounding errors of forces are proportional [m].
  double size_of(Vec q);
  void lower_scale(Vec q);

  Objective& objective_;
  NewtonOptions options_;
  SolverStatistics& statistics_;
  std::function<void(Vec)> reassemble_;
  double scale_ = 0.0;
  double least_target_ = 0.0;
  bool is_rounding_counted_ = false;  // of this stage
  double first_scale_ = 0.0;          // at the guess
  double largest_scale_ = 0.0;        // of all stages [N]
  double intermediate_target_ = 0.0;  // [N]
  int num_lowered_ = 0;               // how often in this run the scale was lowered to that of the iterate
  bool starts_at_solution_ = false;
  IterationStart start_;
  double size_at_start_ = 0.0;  // size_of
  bool has_settled_ = false;    // the last iteration has not lowered the residual by much
  double last_residual_ = 0.0;  // of the iterate before [N]
};

}  // namespace pliant
