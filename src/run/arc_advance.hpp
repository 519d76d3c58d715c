/// Advances a static problem along its path of equilibria (`time.path`).
#pragma once

#include "run/advance.hpp"
#include "run/static_states.hpp"
#include "solver/path_solver.hpp"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// "Time" of a step is the length of the path. A step that goes too far around a bend is not accepted, and the length
/// of the next one follows from the iterations and from the bend. A step beyond the largest or smallest load factor
/// ends there. All methods are collective.
class ArcAdvance final : public Advance {
 public:
  /// `model` outlives the object.
  ArcAdvance(const Config& config, Model& model, const StateView& initial);

  StepAttempt attempt(const Step& step) override;
  void accept(const StepAttempt& attempt) override;
  const PathFinding* path() const override { return &finding_; }
  StateView state() const override { return states_.view(length_); }
  void keep(Archive& archive) override;
  void forget() override { solver_->forget(); }
  std::optional<FailedStage> examine() override { return solver_->examine(); }
  void watch(std::function<void(const StageProgress&)> watcher) override { solver_->watch(std::move(watcher)); }
  const SolverStatistics& solver_statistics() const override { return solver_->statistics(); }
  std::vector<std::string> description() const override { return {description_, "path: by arc length"}; }

 private:
  /// Makes the last accepted state the start of a step, with the tangent there.
  StageReport prepare();
  StageReport find_step(double length);
  bool is_beyond(double load_factor) const { return load_factor >= max_load_ || load_factor <= min_load_; }
  /// Whether the step has left its branch: at a limit point the number of unstable modes changes by one.
  bool is_doubtful(const PathStep& step) const;
  /// The critical point that the step has passed.
  std::optional<CriticalPoint> critical_point(const PathStep& step) const;

  std::string description_;
  StaticStates states_;
  Handle<Vec> settled_;  // the start of the path: the initial state need not be an equilibrium
  double max_load_, min_load_;
  bool keeps_tangent_;  // unknowns mean the same in every step
  std::unique_ptr<PathSolver> solver_;
  PathFinding finding_;
  double length_ = 0.0;
  bool has_earlier_ = false;   // an accepted state before the last one
  int doubtful_attempts_ = 0;  // since the last accepted state
  /// Unstable modes of the last accepted state, if they are known; none without loads.
  std::optional<PetscInt> unstable_before_ = 0;
};

}  // namespace pliant
