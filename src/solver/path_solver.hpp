/// Follows the equilibria of a static problem along their path, beyond limit points of the load.
#pragma once

#include "energy/stage_equation.hpp"
#include "petsc/handle.hpp"
#include "solver/failed_stage.hpp"
#include "solver/newton_loop.hpp"
#include "solver/objective.hpp"
#include "solver/statistics.hpp"
#include "solver/tangent_system.hpp"
#include "time/stage.hpp"

#include <functional>
#include <optional>
#include <utility>
#include <vector>

namespace pliant {

/// An equilibrium that a step along the path has reached.
struct PathStep {
  double load_factor = 0.0;  ///< lambda
  double length = 0.0;       ///< of the step along the path
  /// dlambda/ds at the start and at the end of the step, s from 0 to `length`.
  double slope_at_start = 0.0, slope_at_end = 0.0;
  double turn = 0.0;                       ///< largest angle between the step and the tangents at its ends [rad]
  std::optional<PetscInt> unstable_modes;  ///< negative eigenvalues of the tangent stiffness there, if they are known
};

/// Continuation by arc length (Riks 1979, An incremental approach to the solution of snapping and buckling problems;
/// Keller 1977, Numerical solution of bifurcation and nonlinear eigenvalue problems). The path is the set of points
/// x = (xi, lambda) with r(x) = 0, of unknowns and load factor. Its length is measured by
///
///     <x, y> = (xi . eta / c^2 + lambda mu) / 2,     c = the least |dxi/dlambda| at points so far,
///
/// so that the length grows as the load factor does as long as the response is linear; pressures do not count. With c
/// of the start alone, a structure that stiffens much would be followed by its load factor, which does not pass limit
/// points; Crisfield 1981 (A fast incremental/iterative solution procedure that handles snap-through) leaves the load
/// factor out, which c approaches there. From
/// x_n with the unit tangent t, a step of length s is
///
///     r(x) = 0,   <t, x - x_n> = s,
///
/// which has a regular solution at limit points too, where K = dr/dxi is singular. Each iteration of Newton's method
/// solves two systems with the same factor of K, for f = dr/dlambda:
///
///     K a = r,  K b = f,   dxi = -a - b dlambda,   dlambda from the second equation.
///
/// The tangent is (-b, 1) at the solution, normalized, on the side on which it leads away from x_n: the path never
/// turns back on itself. f is a central difference of residuals, with which prescribed displacements, follower
/// pressures, cavities, motions and whatever else a load factor scales are followed as they are.
///
/// Invariants:
/// - Every decision depends on numbers that are the same on all ranks.
/// - Between calls the equation is posed at the load factor of the last point that was tried.
///
/// All methods are collective.
class PathSolver {
 public:
  /// Poses the stage at a load factor, and sets the prescribed entries of q, the accepted state, to those at its end.
  using PoseStage = std::function<StagePoint(double load_factor, Vec q)>;

  /// `equation` outlives the solver. PETSc options -snes_..., -ksp_..., -pc_... override.
  PathSolver(StageEquation& equation, const NewtonOptions& options, LinearKind linear, PoseStage pose);

  /// Makes the equilibrium q at a load factor the point from which steps start. Its tangent is known if the last step
  /// has ended there (`accept`).
  void start(Vec q, double load_factor);
  bool has_tangent() const { return has_tangent_; }
  /// Finds the equilibrium of the point's load factor near the point, which need not be one.
  StageReport settle();
  /// Finds the tangent at the point, away from the earlier point (q, load factor), or towards larger loads if that is
  /// nullptr. At the start of the path sets the scale of its length.
  StageReport aim(Vec earlier_q, double earlier_load_factor);
  /// Tries a step of this length.
  StageReport step(double length);
  /// After a step beyond a load factor: tries to end it there instead. If that fails, the step remains as it was.
  StageReport land(double load_factor);
  /// The last step tried; valid if it has converged.
  const PathStep& found() const { return found_; }
  /// q = the configuration of the point from which steps start.
  void place(Vec q) { check(VecCopy(equation_.displacements(point_.xi.get()), q)); }
  /// q = the configuration at its end.
  void leave(Vec q) { equation_.leave(trial_.xi.get(), q); }
  /// After a failure: the equation is again what it was at the point from which the step started.
  void give_up(Vec q) { equation_.leave(point_.xi.get(), q); }
  /// The step is accepted. `keeps_tangent`: unknowns mean the same in the next step.
  void accept(bool keeps_tangent);

  /// 1 / (2 c^2), which belongs to the state of a path; 0 before its start.
  double& scale() { return scale_; }

  /// NewtonSolver::examine, forget, watch and statistics.
  std::optional<FailedStage> examine();
  void forget();
  void watch(std::function<void(const StageProgress&)> watcher) { loop_.log().watch(std::move(watcher)); }
  const SolverStatistics& statistics() const { return statistics_; }

 private:
  struct Point {
    Handle<Vec> xi;
    double load = 0.0;
  };
  enum class Hold { arc, load };

  Point make_point() const;
  void assign(const Point& from, Point& to);
  /// <x, y> of two vectors of unknowns, without the load factor: over displacements that are not prescribed.
  double inner(Vec x, Vec y) const;
  /// Poses the equation at a load factor, and sets the prescribed entries of xi.
  void pose(double load, Vec xi);
  /// f = dr/dlambda at x, where the equation is posed before and after.
  void load_derivative(const Point& x, Vec f);
  /// The tangent (-b, 1) at x, where the equation is posed. Also counts unstable modes.
  StageReport find_tangent(const Point& x, Point& tangent);
  double length_of(const Point& direction) const;
  /// Makes its length 1.
  void normalize(Point& direction) const;
  /// Newton's method from the trial point.
  StageReport correct(Hold hold, double length);
  /// One iteration of it; false if the linear systems have no solution, and the reason.
  bool improve(Hold hold, double length, StageReport& report);
  /// Moves the trial point by d_ and this change of the load factor, or as far as no tetrahedron inverts; returns the
  /// fraction.
  double move_trial(double change);
  /// <t, x - x_n> of the trial point.
  double advanced() const;
  /// Measures the step to the trial point.
  StageReport finish(StageReport report);
  void begin_attempt();
  StageReport failed(StageReport report, const char* reason);

  StageEquation& equation_;
  NewtonOptions options_;
  PoseStage pose_;
  SolverStatistics statistics_;
  Objective objective_;
  NewtonLoop loop_;
  TangentSystem system_;
  std::vector<char> counts_;  // owned entries of unknowns: whether they belong to the metric
  double scale_ = 0.0;
  double load_unit_ = 1.0;  // of differences
  bool has_tangent_ = false;
  double last_fraction_ = 1.0;  // of the last Newton step
  std::optional<PetscInt> unstable_modes_;
  Point point_, tangent_, trial_, next_tangent_;
  PathStep found_;
  Handle<Vec> accepted_, q_;  // configurations
  Handle<Vec> entered_, from_, r_, other_r_, f_, a_, b_, d_;
  std::optional<Handle<Vec>> failure_;
};

}  // namespace pliant
