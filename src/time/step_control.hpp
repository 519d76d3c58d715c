/// Which step to try next: a nominal step on a fixed grid of times, shortened when a step fails.
#pragma once

#include "time/step.hpp"

#include <cstdint>
#include <string>

namespace pliant {

/// What the run asks for. dt > 0, 0 < min_dt.
struct StepPlan {
  double origin = 0.0;  ///< nominal step n ends at origin + n dt, the last at `end` [s]
  double dt = 0.0;      ///< nominal step [s]
  double end = 0.0;     ///< end of the run [s]
  double min_dt = 0.0;  ///< a failed step is not halved below this [s]
};

/// Where the run stands; with the plan, all that continues it exactly.
struct StepProgress {
  std::int64_t nominal = 0;  ///< nominal steps completed
  double time = 0.0;         ///< end of the last accepted step [s]
  double limit = 0.0;        ///< the next step may not be longer [s]
};

enum class Retry { again, give_up };

struct RetryDecision {
  Retry retry = Retry::again;
  std::string reason;  ///< in plain words, for the log
};

/// Fixed nominal step with retry. A failed step is halved, and again; after a success the step at most doubles until it
/// is back at the nominal one. Every time origin + n dt is hit, computed by multiplication so that it carries no
/// accumulated rounding, and so is the end: the last step is shortened where the end is no multiple of the step, or
/// longer by a millionth of it, lest a sliver remain. A value: copies are independent.
class StepControl {
 public:
  /// Starts at the plan's origin.
  explicit StepControl(const StepPlan& plan);
  /// Continues.
  StepControl(const StepPlan& plan, const StepProgress& progress);

  bool finished() const { return progress_.nominal >= num_nominal_; }
  /// The step to try. Not when finished.
  Step next() const;
  /// The step `next()` was accepted.
  void accept();
  /// The step `next()` failed for the reason given: `next()` is shorter now, unless the decision is to give up.
  RetryDecision reject(const std::string& reason);

  const StepProgress& progress() const { return progress_; }
  /// Nominal steps from the origin to the end.
  std::int64_t num_nominal() const { return num_nominal_; }

 private:
  double nominal_time(std::int64_t n) const;

  StepPlan plan_;
  std::int64_t num_nominal_ = 0;
  StepProgress progress_;
};

}  // namespace pliant
