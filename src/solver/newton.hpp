/// The solver of a stage: Newton's method on the incremental potential, or on the residual alone, through SNES.
#pragma once

#include "energy/stage_equation.hpp"
#include "petsc/callback.hpp"
#include "petsc/handle.hpp"
#include "solver/corotated_preconditioner.hpp"
#include "solver/failed_stage.hpp"
#include "solver/forcing.hpp"
#include "solver/iteration_start.hpp"
#include "solver/linear.hpp"
#include "solver/merit.hpp"
#include "solver/proximal.hpp"
#include "solver/rank_one_system.hpp"
#include "time/stage.hpp"

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace pliant {

struct NewtonOptions {
  double relative =
      1e-8;  ///< residual over the sum of the norms of the forces that balance at the stage's starting guess
  double absolute = 0.0;  ///< residual [N]
  int max_iterations = 50;
};

/// Part of the forces at work; a solve that leaves more of them has hardly begun.
constexpr double unbalanced_part = 0.1;
/// Part of the forces left where double precision is said to end, beyond which results may show it.
constexpr double doubtful_rounding = 1e-6;

/// What the solver has done since it was made.
struct SolverStatistics {
  long long stages = 0;
  long long minimisations = 0;    ///< stages solved on the incremental potential
  long long residual_solves = 0;  ///< stages solved on the residual, because a term has no potential
  long long newton_iterations = 0;
  long long linear_iterations = 0;
  long long factorizations = 0;         ///< or set-ups of another preconditioner
  long long backtracks = 0;             ///< step lengths refused by the line search
  long long capped_steps = 0;           ///< steps shortened because a tetrahedron would have inverted
  long long projections = 0;            ///< Hessians made positive semidefinite cell by cell
  long long regularizations = 0;        ///< projected Hessians that needed a shift of their diagonal too
  long long rounding_stops = 0;         ///< stages whose residual ended at its rounding floor, above the tolerance
  long long unstable_stages = 0;        ///< equilibria at which the Hessian has negative eigenvalues
  double worst_rounding = 0.0;          ///< the largest residual that they left, over the forces or M v / dt
  long long unbalanced_stops = 0;       ///< stages that `absolute` ended while a tenth of the forces was unbalanced
  bool uses_multigrid_instead = false;  ///< of the factorization, for which memory did not suffice
  double assembly_seconds = 0.0;        ///< residuals, energies, Hessians
  double factorization_seconds = 0.0;
  double solve_seconds = 0.0;
};

/// A stage on its way.
struct StageProgress {
  double seconds = 0.0;  ///< since its start
  int iteration = 0;     ///< of Newton's method
  double residual = 0.0, target = 0.0;
  int linear_iterations = 0;  ///< of the last linear system
};

/// How the solver solves an equation and why, in words for the log.
std::string describe(const StageEquation& equation, LinearKind linear);

/// Newton with the Hessian, a line search on the potential, or on a merit of the residual where there is none, and a
/// ladder for trouble.
///
/// A factorization is kept as long as it pays: conjugate gradients on the current Hessian, preconditioned by the factor
/// of an earlier one, need a few iterations, each a fraction of a factorization; when they need many, the next Hessian
/// is factorized. The ladder: where conjugate gradients fail with a kept factor, the current Hessian is factorized;
/// where the factorization counts negative pivots, the linear solver breaks down, the direction does not descend or no
/// step length helps, the Hessian is projected to positive semidefinite cell by cell; where that does not help either
/// (it may be singular), its diagonal is shifted; where nothing helps, the stage asks for a smaller step. Every rank
/// takes the same decisions: all of them rest on reduced numbers.
///
/// Line search along d = -K^-1 r, from alpha = min(1, 0.9 of the step at which a tetrahedron inverts): Armijo's
/// condition on Phi; where the change of Phi is within its rounding error, the gradient decides (Hager & Zhang 2005,
/// approximate Wolfe condition); +inf backtracks.
///
/// Without a potential the line search works on the residual, with K that may be an approximation of dr/dq. A step is
/// taken where one of two measures falls by a tenth of what a linear equation promises, |.(q + alpha d)| <= (1 - alpha
/// / 10) |.(q)|: the residual in the norm of D^-1; or, where stiff directions hide the progress of soft ones (a strip
/// that bends is stretched by every straight step), the correction K^-1 r in the norm of D, with the K of the
/// iteration: the natural monotonicity test (Deuflhard 2011, Newton Methods for Nonlinear Problems, 3.3). D is the
/// absolute diagonal of the stage's first K. The pivots of an
/// unsymmetric K tell nothing of stability.
///
/// Parts of rank one (the pressure of a cavity depends on its volume) are no part of K: linear systems take them in by
/// the formula of Woodbury, and the iteration remains Newton's.
class NewtonSolver {
 public:
  /// `equation` outlives the solver. PETSc options -snes_..., -ksp_..., -pc_... override. Collective.
  NewtonSolver(StageEquation& equation, const NewtonOptions& options, LinearKind linear);

  /// Solves the stage of configurations, as a StageSolve does: from the guess in q, or from q0 + dt v0 where that
  /// lowers the potential (or the merit) further. Collective.
  StageReport solve(const StagePoint& stage, Vec q);

  /// Looks closely at the last stage, if it could not be solved; before anything else is asked of the equation, whose
  /// other state (pressures) it leaves at the stage's last iterate. Collective.
  std::optional<FailedStage> examine();

  /// Forgets what earlier stages have taught: the next one is solved as a new solver would.
  void forget();

  /// Calls `watcher` at each iteration of Newton's method. Collective.
  void watch(std::function<void(const StageProgress&)> watcher) { watcher_ = std::move(watcher); }

  const SolverStatistics& statistics() const { return statistics_; }

 private:
  static PetscErrorCode residual_callback(SNES, Vec q, Vec r, void* self);
  static PetscErrorCode hessian_callback(SNES, Vec q, Mat K, Mat P, void* self);
  static PetscErrorCode line_search_callback(SNESLineSearch search, void* self);
  static PetscErrorCode convergence_callback(SNES, PetscInt it, PetscReal, PetscReal, PetscReal f,
                                             SNESConvergedReason* reason, void* self);

  /// The residual's rounding floor is an estimate: below this multiple of it nothing is to be gained.
  static constexpr double floor_factor = 4.0;
  enum class Path { minimisation, residual };

  /// The same in the unknowns of the equation.
  StageReport solve_for_unknowns(const StagePoint& stage, Vec q);
  /// Leaves q at the best of the guesses that there are, and phi_ at its height; a reason if there is none.
  std::optional<std::string> choose_guess(const StagePoint& stage, Vec q);
  /// Makes the candidate the guess if it is better.
  void consider(Vec candidate, Vec q);
  /// q = `candidate`, or where a wall stands on the way there from the accepted state: short of it.
  void stop_short_of_walls(Vec accepted, Vec candidate);
  /// Considers guesses that obstacles which have moved onto the accepted state have taken along.
  void go_with_obstacles(const StagePoint& stage, Vec q);
  /// How far what is prescribed was led: not at all, as the accepted state lies beyond a barrier now, a part of its
  /// way, or all of it.
  enum class Carried { not_at_all, partly, all_the_way };
  /// Leads what is prescribed from the accepted state to where it stands in q, and the body with it: by the tangent, on
  /// as many straight ways as it takes; q is then where it ended.
  Carried carry(Vec accepted, Vec q);
  /// Without inertia: in turn, until one arrives, a few iterations of Newton's method to a minimum nearby; a few to any
  /// equilibrium nearby, on the residual and whatever the signs of the Hessian's eigenvalues; and, where steps cut
  /// short do not help, a descent to a minimum far away, to which the body snaps. The first two in the order that led
  /// to the equilibrium before.
  StageReport seek_equilibrium(Vec q);
  /// Goes down from q to where the potential is nearly least, by solutions that are held near the one before; to go on
  /// from when iterations have run out. In the report only iterations count.
  StageReport descend(Vec q, int max_iterations);
  /// Of a residual without potential: a few whole Newton steps from the guess, and damped ones where they do not
  /// arrive; with inertia, a few damped ones before. The stresses extrapolated along a step are near those of
  /// equilibrium even where it stretches a thin body to forces many times those at work, so that the next step takes
  /// them back; a line search that measures residuals would refuse both.
  StageReport solve_residual(Vec q);
  void limit_iterations(int number);
  /// Solves again, with coefficients frozen at the solution, until it stays one.
  void settle_coefficients(Vec q, StageReport& report);
  /// Whether q solves the stage with the coefficients as they are. Leaves the residual in `r_`.
  bool is_settled(Vec q);
  /// Whether the last iteration ran out of iterations near its end.
  bool is_converging() const;
  /// Newton's iteration from q, with coefficients frozen as they are.
  StageReport iterate(Vec q);
  void assemble(Vec q, Projection projection);
  /// Mean of the absolute diagonal of K.
  double mean_diagonal();
  /// Adds to the diagonal of K.
  void shift(double by);
  /// The present K, which is that of q.
  void factorize(Vec q);
  /// The same; where K is indefinite it is shifted, or projected, until it is not. False if the factorization fails.
  bool factorize_definite(Vec q);
  KSP linear_solver() const;
  /// Conjugate gradients for a definite Hessian, GMRES for another.
  void choose_krylov_method();
  /// Whether the factorization counts as many negative eigenvalues as a stable state has.
  bool has_right_inertia() const;
  /// Of the Hessian with its parts of rank one, as the factorization of the present K tells.
  std::optional<PetscInt> negative_eigenvalues() const;
  void linearize(Vec q);
  double target() const { return std::max({options_.relative * scale_, options_.absolute, descent_target_}); }
  /// SNES's line search: along the direction y (q goes to q - y), from one rung of the ladder to the next.
  void search_line(SNESLineSearch search);
  /// q = trial, at the end of a straight line.
  void go_to(Vec trial, Vec q);
  /// Goes along -y as far as it helps; false if no step length does. `slope`: of Phi along -y.
  bool lower_potential(Vec y, double slope, SNESLineSearch search);
  bool lower_residual(Vec y, double slope, SNESLineSearch search);
  /// Whether the correction at a trial step of length alpha along d, with the residual r, is shorter than d by the
  /// required part; else alpha becomes the next length to try.
  bool shortens_correction(Vec r, Vec d, double& alpha);
  /// The length to try first along d.
  double first_length(Vec q, Vec d);
  /// Whether the residual is so near its rounding errors that no more can be expected: the search then ends well.
  bool stops_at_rounding(SNESLineSearch search, double residual, double force_rounding);
  /// Whether the linear system just solved took more iterations than a sound factorization of its matrix leaves.
  bool factor_is_poor() const;
  /// Makes the linear system safer by one rung; false if there is none left.
  bool climb(Vec q);
  bool descends(Vec r, Vec y, double& slope);
  void solve_linear(Vec r, Vec y);
  /// Whether the solution of the last linear system, whose right-hand side was r, is no direction to go.
  bool linear_solver_broke_down(Vec r) const;
  SNESConvergedReason judge(PetscInt iteration, double residual);
  /// Is the residual made of rounding errors alone? Collective.
  bool is_rounding(double residual);
  void count_rounding(double residual);
  /// A guess may be stretched, or near a wall: its forces say little of those that balance at the solution q.
  void lower_scale(Vec q);
  void note_iteration(PetscInt iteration, double residual);
  void note_failure(const StagePoint& stage, Vec q);
  double value(Vec q);
  /// What is to be lowered: the potential at q, or the merit of the residual there.
  double height(Vec q);

  StageEquation& equation_;
  NewtonOptions options_;
  Handle<Mat> K_;
  Handle<Vec> unknowns_, r_, trial_, correction_, last_, guess_, last_trial_, before_;
  Merit merit_;
  Proximal proximal_;
  std::vector<RankOne> rank_one_;  // parts of the Hessian beside K
  Handle<SNES> snes_;
  Handle<PC> preconditioner_;                       // of K
  std::unique_ptr<RankOneSystem> rank_one_system_;  // nullptr if there are no such parts
  std::unique_ptr<NodalRotations> rotations_;       // since the factorization; nullptr if it does not turn
  std::unique_ptr<CorotatedPreconditioner> corotated_;
  CallbackGuard guard_;
  SolverStatistics statistics_;
  std::function<void(const StageProgress&)> watcher_;
  std::chrono::steady_clock::time_point start_of_stage_;
  // Of the stage being solved.
  Path path_ = Path::minimisation;
  bool merit_has_scale_ = false;
  Vec start_ = nullptr;
  Vec solution_ = nullptr;
  double scale_ = 0.0;
  double first_scale_ = 0.0;     // of the guess
  double descent_target_ = 0.0;  // of a solution of `descend` [N]
  int num_lowered_ = 0;          // times in this iteration that the scale became that of the iterate
  double phi_ = 0.0;             // value at the current iterate
  Projection projection_ = Projection::none;
  bool is_regularized_ = false;
  bool has_second_guess_ = false;  // guess_ is one
  bool is_static_ = false;
  bool follows_ = false;            // any equilibrium will do: see `seek_equilibrium`
  bool takes_whole_steps_ = false;  // whatever they do to the residual: see `solve_residual`
  bool took_full_step_ = false;
  bool went_beyond_ = false;  // the last step, whole, led far beyond the minimum along its line
  bool at_rounding_floor_ = false;
  IterationStart start_of_iteration_;
  bool has_direction_ = false;
  std::vector<NewtonIteration> iterations_;
  Handle<Vec> failed_at_;  // where the iteration ended, if the stage could not be solved
  double failed_time_ = 0.0, failed_dt_ = 0.0;
  bool is_refrozen_ = false;  // the iteration starts at a solution for other frozen coefficients
  // Kept across stages.
  Forcing forcing_;
  bool last_is_known_ = false;      // last_ is the solution of the stage before
  bool adapts_tolerance_ = true;    // unless the user gives one
  bool may_choose_krylov_ = false;  // the linear solver is conjugate gradients, and the user did not ask for it
  bool may_keep_factor_ = false;    // the linear solver iterates, so a preconditioner of an earlier Hessian will do
  bool factor_is_wanted_ = true;    // none yet, or the last one has aged
  int trouble_ = 0;                 // grows with each stage for which no equilibrium is found, falls with each other
  bool prefers_following_ = false;  // the equilibrium before was one without a minimum
  double last_shift_ = 0.0;         ///< of an indefinite Hessian, as a part of its mean diagonal
  double fresh_rate_ = 0.0;         // iterations per digit when the factor was that of its matrix
  double excess_iterations_ = 0.0;  // beyond those that fresh factors would have taken, since the last factorization
  bool factor_is_current_ = false;  // it is that of the present Hessian
  bool factor_failed_ = false;      // there is none: the Hessian was singular, or
  bool lacks_memory_ = false;       // memory did not suffice
};

}  // namespace pliant
