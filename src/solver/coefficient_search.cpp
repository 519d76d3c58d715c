#include "solver/coefficient_search.hpp"

#include "base/stopwatch.hpp"
#include "solver/fixed_point.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <fmt/format.h>

namespace pliant {
namespace {

/// Most solves of a stage with coefficients that are frozen again.
constexpr int max_rounds = 60;
/// After so many they must have brought the solution nearer by this factor, or a shorter step costs less.
constexpr int many_rounds = 20;
constexpr double little_nearer = 0.3;
/// Normals and pressures jump where the nearest place changes sides, as over an edge of a mesh, and there may be no
/// solution with its own coefficients between the two: after so many rounds without progress, one that lacks at most
/// this fraction of the drag is taken: a coefficient of friction is hardly known better. Blocks on plates lack 1e-3 to
/// 2e-3.
constexpr int rounds_without_progress = 6;
constexpr double progress = 0.5;
constexpr double little_drag = 1e-2;
/// Drags smaller than this fraction of the forces at work count as that large: a body that leaves the ground has some
/// of any size, and of friction that small nothing depends.
constexpr double least_drag = 1e-4;
/// Fraction of the distance to a wall up to which solutions are extrapolated; at the wall their pressure is infinite.
constexpr double part_to_wall = 0.5;
/// Most of Newton's steps between two rounds, and the fraction of the residual's merit that each may at most leave.
constexpr int max_steps = 8;
constexpr double most_left = 0.7;
constexpr int max_halvings = 3;
/// Relative residual of the linear systems.
constexpr double linear_tolerance = 1e-3;

}  // namespace

CoefficientSearch::CoefficientSearch(Objective& objective, NewtonLoop& loop, SolverStatistics& statistics)
    : objective_(objective),
      equation_(objective.equation()),
      loop_(loop),
      statistics_(statistics),
      merit_([this] { return equation_.make_vector(); }),
      r_(equation_),
      trial_(equation_),
      trial_residual_(equation_),
      d_(equation_),
      diagonal_(equation_) {}

bool CoefficientSearch::is_settled(Vec q) {
  objective_.gradient(q, r_.get());
  return loop_.convergence().is_solution(norm(r_.get()), q);
}

double CoefficientSearch::missing_part(Vec q) {
  equation_.drag(q, q, trial_.get());
  const double least = std::max(least_drag * equation_.force_scale(q), std::numeric_limits<double>::min());
  return norm(r_.get()) / std::max(norm(trial_.get()), least);
}

void CoefficientSearch::settle(Vec q, StageReport& report) {
  std::optional<FixedPoint> rounds;
  double least = std::numeric_limits<double>::infinity();
  int last_progress = 0;
  for (int round = 0; report.outcome == StageOutcome::converged && equation_.refreeze(q); ++round) {
    if (is_settled(q)) return;
    if (round >= rounds_without_progress) {
      const double missing = missing_part(q);
      if (missing < progress * least) last_progress = round;
      least = std::min(least, missing);
      if (round - last_progress >= rounds_without_progress && missing <= std::min(little_drag, least / progress)) {
        ++statistics_.unsettled_stages;
        statistics_.worst_unsettled = std::max(statistics_.worst_unsettled, missing);
        return;
      }
    }
    if (round == max_rounds || (round >= many_rounds && rounds && rounds->error() > little_nearer)) {
      report.outcome = StageOutcome::retry;
      report.reason = fmt::format(
          "friction did not settle within {} solves, each with the normal forces of the previous one", round);
      return;
    }
    const int before = report.newton_iterations;
    if (step_to_solution(q, report)) return;
    if (report.newton_iterations > before) {
      rounds.reset();
    } else if (!rounds) {
      rounds.emplace(q);
    } else {
      Vec step = rounds->step(q);
      check(VecCopy(q, trial_.get()));
      check(VecAXPY(trial_.get(), std::min(1.0, part_to_wall * equation_.max_step(q, step)), step));
      equation_.refreeze(trial_.get());
      rounds->take(trial_.get());
    }
    loop_.resume(q);
    const StageReport again = loop_.run(q);
    report = {again.outcome, again.reason, report.newton_iterations + again.newton_iterations,
              report.linear_iterations + again.linear_iterations};
  }
}

bool CoefficientSearch::step_to_solution(Vec q, StageReport& report) {
  for (int i = 0; i < max_steps; ++i) {
    const auto before = step(q, report);
    if (!before) return false;
    if (is_settled(q)) return true;
    if (merit_.of_residual(r_.get()) > most_left * *before) return false;
  }
  return false;
}

std::optional<double> CoefficientSearch::step(Vec q, StageReport& report) {
  LinearSystem& system = loop_.system();
  system.assemble(q);
  equation_.size_of_diagonal(system.sparse_matrix(), diagonal_.get());
  merit_.set_scale(diagonal_.get());
  if (!system.prepare(q)) return std::nullopt;
  PetscInt iterations = 0;
  {
    const Stopwatch watch(statistics_.solve_seconds);
    if (!coupled_) coupled_.emplace(equation_, loop_.linear_solver());
    iterations = coupled_->solve(q, system.matrix(), r_.get(), d_.get(), linear_tolerance);
  }
  equation_.refreeze(q);
  statistics_.linear_iterations += iterations;
  report.linear_iterations += static_cast<int>(iterations);
  if (iterations == 0) return std::nullopt;
  check(VecScale(d_.get(), -1.0));
  const double start = merit_.of_residual(r_.get());
  double length = std::min(1.0, inversion_margin * equation_.max_step(q, d_.get()));
  for (int i = 0; i <= max_halvings; ++i, length *= 0.5) {
    check(VecWAXPY(trial_.get(), length, d_.get(), q));
    equation_.refreeze(trial_.get());
    objective_.gradient(trial_.get(), trial_residual_.get());
    if (!(merit_.of_residual(trial_residual_.get()) < start)) continue;
    check(VecCopy(trial_.get(), q));
    check(VecCopy(trial_residual_.get(), r_.get()));
    ++statistics_.newton_iterations;
    ++report.newton_iterations;
    return start;
  }
  equation_.refreeze(q);
  return std::nullopt;
}

}  // namespace pliant
