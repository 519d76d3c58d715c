#include "solver/root_search.hpp"

#include <algorithm>

namespace pliant {
namespace {

/// Most iterations of a kind before another kind is tried: whole steps converge within a few, or not at all.
constexpr int few = 12;
/// Steps of descent, and damped ones, before the other kind has its turn: the Hessians of descent, which are not the
/// exact ones, converge slowly.
constexpr int turn = 6;
/// Most stages that begin with what has helped before damped steps are tried again.
constexpr int most_patience = 32;

}  // namespace

/// The runs of one stage.
class RootSearch::Runs {
 public:
  Runs(Objective& objective, Iteration& iteration, Vec q)
      : objective_(objective), iteration_(iteration), q_(q), start_(objective.equation().make_vector()) {
    start_here();
  }

  /// The next run that does not continue an earlier one starts here.
  void start_here() { check(VecCopy(q_, start_.get())); }
  /// Another run, which continues one that converges; whether it is the last one.
  bool run(Aim aim, int limit) {
    if (newton_ > 0 && !continues_ && !iteration_.is_converging()) {
      check(VecCopy(start_.get(), q_));
      iteration_.renew_factor();
      iteration_.begin_again(q_);
    }
    continues_ = false;
    objective_.set_aim(aim);
    report_ = iteration_.run(q_, limit);
    newton_ += report_.newton_iterations;
    linear_ += report_.linear_iterations;
    objective_.set_aim(objective_.usual_aim());
    return report_.outcome != StageOutcome::retry || objective_.equation().is_far_from_guess(q_);
  }
  /// Steps of descent, a few at a time, each time followed by damped ones; whether the last run was the last one.
  bool descend(int max_iterations) {
    for (int spent = 0; spent < max_iterations; spent += 2 * turn) {
      if (run(Aim::descent, turn)) return true;
      start_here();
      continues_ = true;
      if (run(Aim::root, turn)) return true;
      if (iteration_.is_converging()) return false;
    }
    return false;
  }
  StageReport report() const {
    StageReport all = report_;
    all.newton_iterations = newton_;
    all.linear_iterations = linear_;
    return all;
  }

 private:
  Objective& objective_;
  Iteration& iteration_;
  Vec q_;
  Handle<Vec> start_;
  StageReport report_;
  int newton_ = 0, linear_ = 0;
  bool continues_ = false;  // the next run continues the last one, whatever that has come to
};

StageReport RootSearch::seek(Vec q, int max_iterations) {
  if (max_iterations <= few) return iteration_.run(q);
  Runs runs(objective_, iteration_, q);
  const auto run = [&](Aim aim) { return aim == Aim::descent ? runs.descend(max_iterations) : runs.run(aim, few); };
  const bool is_static = objective_.is_static();
  const Aim first = is_static ? Aim::whole_steps : learned_.num_left > 0 ? learned_.preferred : Aim::root;
  Aim aim = first;
  bool is_over = run(aim);
  for (const Aim next : {Aim::whole_steps, Aim::descent}) {
    if (is_over || is_static || aim == Aim::descent || iteration_.is_converging()) break;
    if (next == aim) continue;
    aim = next;
    is_over = run(aim);
  }
  const Aim helped = is_over || iteration_.is_converging() ? aim : Aim::root;
  if (helped == Aim::root) {
    learned_ = {};
  } else if (helped == first) {
    --learned_.num_left;
  } else {
    learned_ = {helped, learned_.patience, std::min(2 * learned_.patience, most_patience)};
  }
  if (!is_over) runs.run(Aim::root, max_iterations);
  return runs.report();
}

}  // namespace pliant
