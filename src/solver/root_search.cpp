#include "solver/root_search.hpp"

namespace pliant {
namespace {

/// Most iterations of a kind before the other kind is tried: whole steps converge within a few, or not at all.
constexpr int few = 12;

}  // namespace

StageReport RootSearch::seek(Vec q, int max_iterations) {
  if (max_iterations <= few) return iteration_.run(q);
  const Handle<Vec> guess = objective_.equation().make_vector();
  check(VecCopy(q, guess.get()));
  StageReport report;
  int newton = 0, linear = 0;
  const auto run = [&](Aim aim, int limit) {
    if (newton > 0 && !iteration_.is_converging()) {
      check(VecCopy(guess.get(), q));
      iteration_.renew_factor();
      iteration_.begin_again(q);
    }
    objective_.set_aim(aim);
    report = iteration_.run(q, limit);
    newton += report.newton_iterations;
    linear += report.linear_iterations;
    objective_.set_aim(objective_.usual_aim());
    return report.outcome != StageOutcome::retry;
  };
  bool uses_whole_steps = objective_.is_static() || prefers_whole_steps_;
  bool is_over = run(uses_whole_steps ? Aim::whole_steps : Aim::root, few);
  if (!is_over && !uses_whole_steps && !iteration_.is_converging()) {
    uses_whole_steps = true;
    is_over = run(Aim::whole_steps, few);
  }
  prefers_whole_steps_ = uses_whole_steps && (is_over || iteration_.is_converging());
  if (!is_over) run(Aim::root, max_iterations);
  report.newton_iterations = newton;
  report.linear_iterations = linear;
  return report;
}

}  // namespace pliant
