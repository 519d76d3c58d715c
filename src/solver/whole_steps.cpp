#include "solver/whole_steps.hpp"

namespace pliant {
namespace {

/// Most whole steps from a guess: they converge within a few, or not at all.
constexpr int max_whole_steps = 12;

}  // namespace

StageReport solve_residual(Objective& objective, Iteration& iteration, Vec q, int max_iterations) {
  if (max_iterations <= max_whole_steps) return iteration.run(q);
  const Handle<Vec> guess = objective.equation().make_vector();
  check(VecCopy(q, guess.get()));
  StageReport report;
  int newton = 0, linear = 0;
  const auto attempt = [&](Aim aim, int limit) {
    if (newton > 0 && !iteration.is_converging()) {
      check(VecCopy(guess.get(), q));
      iteration.renew_factor();
      iteration.begin_again(q);
    }
    objective.set_aim(aim);
    report = iteration.run(q, limit);
    newton += report.newton_iterations;
    linear += report.linear_iterations;
    objective.set_aim(objective.usual_aim());
    return report.outcome != StageOutcome::retry;
  };
  const bool arrives = objective.is_static()
                           ? attempt(Aim::whole_steps, max_whole_steps)
                           : attempt(Aim::root, max_whole_steps) ||
                                 (!iteration.is_converging() && attempt(Aim::whole_steps, max_whole_steps));
  if (!arrives) attempt(Aim::root, max_iterations);
  report.newton_iterations = newton;
  report.linear_iterations = linear;
  return report;
}

}  // namespace pliant
