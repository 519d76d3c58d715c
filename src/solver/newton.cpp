#include "solver/newton.hpp"

#include "petsc/copy_of.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace pliant {
namespace {

/// Most solves of a static stage whose bodies rotate far in each.
constexpr int max_turns = 20;

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
      unknowns_(equation.make_vector()),
      objective_(equation, statistics_),
      loop_(objective_, options, linear, statistics_),
      guesses_(objective_, loop_.system(), statistics_),
      equilibria_(objective_, loop_, statistics_, options.relative, options.slenderness),
      roots_(objective_, loop_),
      coefficients_(objective_, loop_, statistics_),
      tangent_(objective_, loop_.system(), loop_.linear_solver()) {}

StageReport NewtonSolver::solve(const StagePoint& stage, Vec q) {
  ++statistics_.stages;
  StageReport report;
  for (int turn = 0;; ++turn) {
    const StageReport before = std::move(report);
    const auto guess = turn == 0 ? Guess::best : Guess::given;
    report = solve_for_unknowns(equation_.enter(stage, q, unknowns_.get()), unknowns_.get(), guess);
    report.newton_iterations += before.newton_iterations;
    report.linear_iterations += before.linear_iterations;
    const bool is_over = report.outcome == StageOutcome::fatal || has_left(unknowns_.get());
    if (is_over || !equation_.is_far_from_guess(unknowns_.get())) break;
    if (turn == max_turns) {
      report.outcome = StageOutcome::retry;
      report.reason = "bodies rotate on and on in the search for an equilibrium";
      break;
    }
    equation_.leave(unknowns_.get(), q);
  }
  report.outcome == StageOutcome::converged ? equation_.leave(unknowns_.get(), q) : equation_.give_up();
  return report;
}

StageReport NewtonSolver::solve_for_unknowns(const StagePoint& stage, Vec q, Guess which) {
  objective_.begin_stage(stage);
  loop_.begin_stage();
  failure_.reset();
  ++(objective_.is_minimised() ? statistics_.minimisations : statistics_.residual_solves);
  equation_.freeze(q);
  if (may_follow()) objective_.set_aim(equilibria_.first_aim());
  StartingGuess guess = which == Guess::given ? guesses_.keep(q) : guesses_.choose(stage, q);
  if (which == Guess::given && !std::isfinite(guess.measure)) guess = guesses_.choose(stage, q);
  objective_.set_aim(objective_.usual_aim());
  StageReport report{StageOutcome::retry, guess.failure.value_or("")};
  if (!guess.failure) {
    loop_.use_guess(q, guess.measure);
    const Handle<Vec> start = objective_.is_static() ? copy_of(q) : Handle<Vec>();
    // What only friction holds has no equilibrium without it: not many iterations are spent on that again.
    constexpr int few = 16;
    report = iterate(q, needs_drag_ ? std::min(few, options_.max_iterations) : options_.max_iterations);
    const bool is_over = report.outcome != StageOutcome::retry || equation_.is_far_from_guess(q);
    if (start && !is_over) report = iterate_with_drag(q, start.get(), report);
    coefficients_.settle(q, report);
    if (report.outcome != StageOutcome::fatal && has_left(q)) {
      report.outcome = StageOutcome::retry;
      report.reason = fmt::format(
          "nothing holds the bodies against the loads: without inertia they move on and on, by "
          "more than {:.1g} m",
          options_.reach);
    }
  }
  if (report.outcome == StageOutcome::converged) {
    guesses_.remember(q);
  } else {
    failure_ = Failure{{}, stage.time, stage.dt};
    check(VecDuplicate(q, failure_->q.out()));
    check(VecCopy(q, failure_->q.get()));
  }
  return report;
}

// Far away, rounding errors of a stiff body's forces are as large as the loads, which then seem to be in balance.
bool NewtonSolver::has_left(Vec q) {
  if (!objective_.is_static()) return false;
  PetscReal largest = 0.0;
  check(VecNorm(equation_.displacements(q), NORM_INFINITY, &largest));
  return largest > options_.reach;
}

StageReport NewtonSolver::iterate(Vec q, int max_iterations) {
  if (may_follow()) return equilibria_.seek(q, guesses_.second(), max_iterations);
  if (objective_.is_minimised()) return loop_.run(q);
  return roots_.seek(q, max_iterations);
}

StageReport NewtonSolver::iterate_with_drag(Vec q, Vec guess, const StageReport& failed) {
  if (!equation_.refreeze(guess)) return failed;
  const bool was_cut_short = std::exchange(needs_drag_, true);
  check(VecCopy(guess, q));
  StageReport report = equilibria_.hold_softly(q, options_.max_iterations);
  const auto add = [&](const StageReport& other) {
    report.newton_iterations += other.newton_iterations;
    report.linear_iterations += other.linear_iterations;
  };
  if (report.outcome == StageOutcome::converged) {
    const StageReport held = std::exchange(report, iterate(q, options_.max_iterations));
    add(held);
  } else if (report.outcome == StageOutcome::retry && report.reason.empty()) {
    report.reason = failed.reason;
    if (was_cut_short) {
      check(VecCopy(guess, q));
      equation_.freeze(q);
      const StageReport held = std::exchange(report, iterate(q, options_.max_iterations));
      add(held);
    }
  }
  add(failed);
  return report;
}

void NewtonSolver::forget() {
  loop_.forget();
  guesses_.forget();
  equilibria_.forget();
  roots_.forget();
  needs_drag_ = false;
}

std::optional<FailedStage> NewtonSolver::examine() {
  if (!failure_) return std::nullopt;
  FailedStage stage = look_along_direction(objective_, failure_->q.get(), loop_.last_direction());
  stage.time = failure_->time;
  stage.dt = failure_->dt;
  stage.tolerance = loop_.convergence().target();
  stage.force_scale = loop_.convergence().scale();
  stage.lacks_memory = loop_.system().factor().lacks_memory();
  stage.iterations = loop_.log().iterations();
  return stage;
}

}  // namespace pliant
