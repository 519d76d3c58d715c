#include "solver/newton.hpp"

#include "base/stopwatch.hpp"
#include "solver/fixed_point.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

namespace pliant {
namespace {

/// Whole steps from a guess: they arrive within a few, or not at all.
constexpr int max_strides = 12;
/// How often the forces of a guess give way to those at the iterate that met the tolerance for them. At a solution
/// without stress there are none, and it is enough to have met it for the remains of remains.
constexpr int max_lowered = 3;
/// The forces of a guess are too large a measure if those at the iterate are less than this part of them.
constexpr double much_less = 0.1;
/// Forces that are less than this part of those of the guess have vanished.
constexpr double tiny_part = 1e-6;
/// Iterations that have brought the residual below this part of the first one are on their way.
constexpr double nearly_there = 1e-3;
/// Forces up to this multiple of the rounding floor are none.
constexpr double no_forces = 10.0;

/// Solves of a stage with coefficients frozen anew.
constexpr int max_refreezes = 60;
/// Part of the way to a wall up to which coefficients are extrapolated, whose pressure goes to infinity there.
constexpr double part_to_wall = 0.5;

std::string in_words(SNESConvergedReason reason) {
  switch (reason) {
    case SNES_DIVERGED_FNORM_NAN:
      return "the residual is not a number";
    case SNES_DIVERGED_MAX_IT:
      return "Newton's method ran out of iterations";
    case SNES_DIVERGED_LINE_SEARCH:
      return "no step length lowers the potential, or the residual where there is none";
    case SNES_DIVERGED_JACOBIAN_DOMAIN:
      return "the Hessian is singular, whatever is added to it";
    case SNES_DIVERGED_LINEAR_SOLVE:
      return "the linear solver failed";
    default:
      return fmt::format("Newton's method stopped ({})", SNESConvergedReasons[reason]);
  }
}

}  // namespace

std::string describe(const StageEquation& equation, LinearKind linear) {
  const auto names = equation.non_potentials();
  std::string how = "Newton on the incremental potential";
  if (!names.empty()) {
    how = fmt::format("Newton on the residual with merits r.D^-1 r and |K^-1 r|, because '{}' {} no potential",
                      fmt::join(names, "' and '"), names.size() == 1 ? "has" : "have");
  }
  return how + "; " + describe(linear, equation.symmetry());
}

NewtonSolver::NewtonSolver(StageEquation& equation, const NewtonOptions& options, LinearKind linear)
    : equation_(equation),
      options_(options),
      K_(equation.make_hessian()),
      unknowns_(equation.make_vector()),
      r_(equation.make_vector()),
      trial_(equation.make_vector()),
      correction_(equation.make_vector()),
      last_(equation.make_vector()),
      guess_(equation.make_vector()),
      last_trial_(equation.make_vector()),
      before_(equation.make_vector()),
      merit_(equation.make_vector()) {
  SNES snes = nullptr;
  check(SNESCreate(equation.comm(), snes_.out()));
  snes = snes_.get();
  check(SNESSetType(snes, SNESNEWTONLS));
  check(SNESSetFunction(snes, r_.get(), residual_callback, this));
  check(SNESSetJacobian(snes, K_.get(), K_.get(), hessian_callback, this));
  check(SNESSetConvergenceTest(snes, convergence_callback, this, nullptr));
  limit_iterations(options.max_iterations);
  // Preconditioners are set up in `factorize`, nowhere else.
  check(SNESSetLagPreconditioner(snes, -1));
  check(SNESSetCheckJacobianDomainError(snes, PETSC_TRUE));
  // A failed linear solve is the line search's business: it climbs the ladder.
  check(SNESSetMaxLinearSolveFailures(snes, PETSC_MAX_INT));
  SNESLineSearch search = nullptr;
  check(SNESGetLineSearch(snes, &search));
  check(SNESLineSearchSetType(search, SNESLINESEARCHSHELL));
  check(SNESLineSearchShellSetUserFunc(search, line_search_callback, this));
  KSP ksp = nullptr;
  check(SNESGetKSP(snes, &ksp));
  const auto coarsening = linear == LinearKind::p_multigrid ? equation.make_coarsening() : std::nullopt;
  configure_linear_solver(ksp, K_.get(), linear, equation.symmetry(), coarsening ? &*coarsening : nullptr);
  check(SNESSetFromOptions(snes));
  PC pc = nullptr;
  check(KSPGetPC(ksp, &pc));
  check(PetscObjectReference(reinterpret_cast<PetscObject>(pc)));
  preconditioner_ = Handle<PC>(pc);
  for (std::size_t k = 0; k < equation.num_rank_one(); ++k) rank_one_.push_back({0.0, equation.make_vector()});
  if (!rank_one_.empty()) {
    rank_one_system_ = std::make_unique<RankOneSystem>(ksp, K_.get(), rank_one_);
    check(SNESSetJacobian(snes, rank_one_system_->matrix(), K_.get(), hessian_callback, this));
  }
  PetscBool solves_directly = PETSC_FALSE;
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(ksp), KSPPREONLY, &solves_directly));
  may_keep_factor_ = !solves_directly;
  PetscBool is_cg = PETSC_FALSE;
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(ksp), KSPCG, &is_cg));
  may_choose_krylov_ = is_cg == PETSC_TRUE && equation.symmetry() == Symmetry::symmetric;
  PetscBool turns = PETSC_TRUE;
  check(PetscOptionsGetBool(nullptr, nullptr, "-newton_turn_factor", &turns, nullptr));
  // Multigrid smooths with the present K, which has turned already.
  if (turns && may_keep_factor_ && is_factorization(pc)) rotations_ = equation.make_rotations();
  if (rotations_) corotated_ = std::make_unique<CorotatedPreconditioner>(ksp, *rotations_);
  PetscBool tolerance_is_given = PETSC_FALSE;
  check(PetscOptionsHasName(nullptr, nullptr, "-ksp_rtol", &tolerance_is_given));
  adapts_tolerance_ = !tolerance_is_given;
}

PetscErrorCode NewtonSolver::residual_callback(SNES, Vec q, Vec r, void* self) {
  auto* solver = static_cast<NewtonSolver*>(self);
  return solver->guard_.run([&] {
    const Stopwatch watch(solver->statistics_.assembly_seconds);
    solver->equation_.gradient(q, r);
    solver->proximal_.add_gradient(q, r);
  });
}

PetscErrorCode NewtonSolver::hessian_callback(SNES, Vec q, Mat, Mat, void* self) {
  auto* solver = static_cast<NewtonSolver*>(self);
  return solver->guard_.run([&] { solver->linearize(q); });
}

PetscErrorCode NewtonSolver::line_search_callback(SNESLineSearch search, void* self) {
  auto* solver = static_cast<NewtonSolver*>(self);
  return solver->guard_.run([&] { solver->search_line(search); });
}

PetscErrorCode NewtonSolver::convergence_callback(SNES, PetscInt it, PetscReal, PetscReal, PetscReal f,
                                                  SNESConvergedReason* reason, void* self) {
  auto* solver = static_cast<NewtonSolver*>(self);
  return solver->guard_.run([&] { *reason = solver->judge(it, f); });
}

double NewtonSolver::value(Vec q) {
  const Stopwatch watch(statistics_.assembly_seconds);
  return equation_.value(q) + proximal_.value(q);
}

double NewtonSolver::height(Vec q) {
  if (path_ == Path::minimisation) return value(q);
  const Stopwatch watch(statistics_.assembly_seconds);
  equation_.gradient(q, r_.get());
  return merit_.of_residual(r_.get());
}

SNESConvergedReason NewtonSolver::judge(PetscInt iteration, double residual) {
  note_iteration(iteration, residual);
  if (!std::isfinite(residual)) return SNES_DIVERGED_FNORM_NAN;
  if (iteration > 0 && !takes_whole_steps_) took_full_step_ ? forcing_.observe(residual) : forcing_.forget();
  if (iteration == 0) {
    num_lowered_ = 0;
    went_beyond_ = false;
  }
  if (iteration > 0 && residual <= target() && num_lowered_ < max_lowered) {
    lower_scale(solution_);
    if (residual > target()) ++num_lowered_;
  }
  if (residual <= target()) {
    if (residual > unbalanced_part * scale_) ++statistics_.unbalanced_stops;
    return SNES_CONVERGED_FNORM_RELATIVE;
  }
  if (iteration == 0) start_of_iteration_ = {residual, norm(solution_)};
  if (at_rounding_floor_ || ((iteration > 0 || is_refrozen_) && is_rounding(residual))) {
    count_rounding(residual);
    return SNES_CONVERGED_FNORM_ABS;
  }
  return SNES_CONVERGED_ITERATING;
}

void NewtonSolver::count_rounding(double residual) {
  ++statistics_.rounding_stops;
  const double size = std::max({equation_.force_scale(solution_), equation_.inertia_scale(), first_scale_ * tiny_part});
  // A body at rest without stress: its forces are rounding errors themselves.
  const bool is_free_of_forces = is_static_ && size <= no_forces * floor_factor * equation_.rounding_floor(solution_);
  if (size > 0.0 && !is_free_of_forces)
    statistics_.worst_rounding = std::max(statistics_.worst_rounding, residual / size);
}

void NewtonSolver::lower_scale(Vec q) {
  const double now = equation_.force_scale(q);
  if (now < much_less * scale_) scale_ = now;
}

bool NewtonSolver::is_rounding(double residual) {
  double floor = floor_factor * equation_.rounding_floor(solution_);
  if (residual > floor) return false;
  if (residual > doubtful_rounding * scale_) {
    // The last Hessian may be one near a wall that is far by now.
    assemble(solution_, Projection::none);
    floor = floor_factor * equation_.rounding_floor(solution_);
    if (residual > floor) return false;
  }
  return start_of_iteration_.allows_rounding(residual, floor, norm(solution_));
}

void NewtonSolver::forget() {
  prefers_following_ = false;
  trouble_ = 0;
  last_shift_ = 0.0;
  forcing_.forget();
  factor_is_wanted_ = true;
  last_is_known_ = false;
}

StageReport NewtonSolver::solve(const StagePoint& stage, Vec q) {
  ++statistics_.stages;
  start_of_stage_ = std::chrono::steady_clock::now();
  const StageReport report = solve_for_unknowns(equation_.enter(stage, q, unknowns_.get()), unknowns_.get());
  report.outcome == StageOutcome::converged ? equation_.leave(unknowns_.get(), q) : equation_.give_up();
  return report;
}

StageReport NewtonSolver::solve_for_unknowns(const StagePoint& stage, Vec q) {
  path_ = equation_.is_potential() ? Path::minimisation : Path::residual;
  ++(path_ == Path::minimisation ? statistics_.minimisations : statistics_.residual_solves);
  merit_has_scale_ = false;
  at_rounding_floor_ = false;
  has_direction_ = false;
  lacks_memory_ = false;
  iterations_.clear();
  failed_at_ = {};
  scale_ = 0.0;
  start_ = stage.q0;
  solution_ = q;
  is_refrozen_ = false;
  // Without inertia there may be no minimum nearby, and still an equilibrium.
  is_static_ = equation_.is_static();
  const bool may_follow = is_static_ && equation_.symmetry() != Symmetry::unsymmetric;
  follows_ = may_follow && prefers_following_;
  equation_.freeze(q);
  const Path usual = path_;
  if (follows_) path_ = Path::residual;
  const auto no_guess = choose_guess(stage, q);
  path_ = usual;
  if (no_guess) {
    note_failure(stage, q);
    return {StageOutcome::retry, *no_guess};
  }
  scale_ = first_scale_ = equation_.force_scale(q);
  StageReport report = may_follow ? seek_equilibrium(q) : path_ == Path::residual ? solve_residual(q) : iterate(q);
  settle_coefficients(q, report);
  if (report.outcome == StageOutcome::converged) {
    last_is_known_ = true;
    check(VecCopy(q, last_.get()));
  } else {
    note_failure(stage, q);
  }
  return report;
}

void NewtonSolver::limit_iterations(int number) {
  // No tolerance on the step: SNES would compare it after a failed line search too, with the lengths of an earlier
  // step.
  check(SNESSetTolerances(snes_.get(), PETSC_DEFAULT, PETSC_DEFAULT, 0.0, number, PETSC_MAX_INT));
}

StageReport NewtonSolver::solve_residual(Vec q) {
  if (options_.max_iterations <= max_strides) return iterate(q);
  const Handle<Vec> guess = equation_.make_vector();
  check(VecCopy(q, guess.get()));
  StageReport report;
  int newton = 0, linear = 0;
  const auto attempt = [&](bool takes_whole_steps, int max_iterations) {
    if (newton > 0 && !is_converging()) {
      check(VecCopy(guess.get(), q));
      equation_.extrapolate_from(nullptr);
      at_rounding_floor_ = false;
      factor_is_wanted_ = true;
      scale_ = first_scale_;
    }
    takes_whole_steps_ = takes_whole_steps;
    limit_iterations(max_iterations);
    report = iterate(q);
    newton += report.newton_iterations;
    linear += report.linear_iterations;
    takes_whole_steps_ = false;
    return report.outcome != StageOutcome::retry;
  };
  const bool arrives = is_static_ ? attempt(true, max_strides)
                                  : attempt(false, max_strides) || (!is_converging() && attempt(true, max_strides));
  if (!arrives) attempt(false, options_.max_iterations);
  limit_iterations(options_.max_iterations);
  report.newton_iterations = newton;
  report.linear_iterations = linear;
  return report;
}

void NewtonSolver::settle_coefficients(Vec q, StageReport& report) {
  std::optional<FixedPoint> rounds;
  for (int round = 0; report.outcome == StageOutcome::converged && equation_.refreeze(q); ++round) {
    if (round == max_refreezes) {
      report.outcome = StageOutcome::retry;
      report.reason =
          fmt::format("friction did not settle within {} solves with the pressure of the one before", max_refreezes);
      return;
    }
    if (is_settled(q)) return;
    if (!rounds) {
      rounds.emplace(q);
    } else {
      Vec step = rounds->step(q);
      check(VecCopy(q, trial_.get()));
      check(VecAXPY(trial_.get(), std::min(1.0, part_to_wall * equation_.max_step(q, step)), step));
      equation_.refreeze(trial_.get());
      rounds->take(trial_.get());
    }
    if (path_ == Path::minimisation) phi_ = value(q);
    at_rounding_floor_ = false;
    is_refrozen_ = true;
    const StageReport again = iterate(q);
    report = {again.outcome, again.reason, report.newton_iterations + again.newton_iterations,
              report.linear_iterations + again.linear_iterations};
  }
}

bool NewtonSolver::is_settled(Vec q) {
  equation_.gradient(q, r_.get());
  const double residual = norm(r_.get());
  lower_scale(q);
  return residual <= target() || is_rounding(residual);
}

bool NewtonSolver::is_converging() const {
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  check(SNESGetConvergedReason(snes_.get(), &reason));
  return reason == SNES_DIVERGED_MAX_IT && iterations_.back().residual < nearly_there * iterations_.front().residual;
}

StageReport NewtonSolver::iterate(Vec q) {
  const double before = statistics_.factorization_seconds + statistics_.assembly_seconds + statistics_.solve_seconds;
  double total = 0.0;
  {
    const Stopwatch watch(total);
    guard_.rethrow(SNESSolve(snes_.get(), nullptr, q));
  }
  const double accounted =
      statistics_.factorization_seconds + statistics_.assembly_seconds + statistics_.solve_seconds - before;
  statistics_.solve_seconds += std::max(0.0, total - accounted);  // the solves SNES does itself

  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  PetscInt newton = 0, linear = 0;
  check(SNESGetConvergedReason(snes_.get(), &reason));
  check(SNESGetIterationNumber(snes_.get(), &newton));
  check(SNESGetLinearSolveIterations(snes_.get(), &linear));
  if (reason == SNES_DIVERGED_LINE_SEARCH && num_lowered_ > 0) {
    // It has met the tolerance for the forces of the guess, and is as near to forces that vanish as it can be.
    reason = SNES_CONVERGED_FNORM_ABS;
    count_rounding(iterations_.back().residual);
  }
  statistics_.newton_iterations += newton;
  statistics_.linear_iterations += linear;
  StageReport report;
  report.newton_iterations = static_cast<int>(newton);
  report.linear_iterations = static_cast<int>(linear);
  if (reason > 0) {
    report.reason = reason == SNES_CONVERGED_FNORM_ABS ? "converged to the rounding of the forces" : "converged";
  } else {
    report.outcome = StageOutcome::retry;
    report.reason = in_words(reason);
    if (lacks_memory_) {
      // A shorter step takes as much.
      report.outcome = StageOutcome::fatal;
      report.reason = "memory does not suffice for the factorization (MUMPS)";
    }
  }
  return report;
}

}  // namespace pliant
