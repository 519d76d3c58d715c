/// Decides which step to try next: a nominal step on a fixed grid of times, shortened when a step fails, or steps whose
/// length follows the error, or steps along a path.
#pragma once

#include "petsc/archive.hpp"
#include "time/step.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// Adaptive steps, whose length follows the error of the method.
struct AdaptivePlan {
  double max_dt = 0.0;      ///< longest step [s]
  double interval = 0.0;    ///< the times origin + k interval are hit (output); 0: none [s]
  double max_growth = 0.0;  ///< limit of the ratio of successive steps (Method::max_growth)
  int order = 1;            ///< the error of a step grows as dt^(order + 1)
};

/// Steps along a path, whose end is not known beforehand.
struct PathPlan {
  double max_dt = 0.0;  ///< longest step
};

/// The quantity that steps advance, as messages name it: time, or the load factor of a static problem, or the length of
/// its path.
struct StepVariable {
  std::string name = "t";
  std::string unit = "s";  ///< empty if there is none
};

/// The plan of a run. dt > 0, 0 < min_dt <= max_dt.
struct StepPlan {
  double origin = 0.0;  ///< nominal step n ends at origin + n dt, the last at `end` [s]
  double dt = 0.0;      ///< nominal step; with adaptive steps the first to be tried [s]
  double end = 0.0;     ///< end of the run [s]
  double min_dt = 0.0;  ///< neither a failure nor an error makes a step shorter, except by equal steps to a target [s]
  std::vector<double> events = {};  ///< rising times at which loads may have a kink or a jump: steps end there [s]
  std::optional<AdaptivePlan> adaptive = {};  ///< empty: nominal steps
  StepVariable variable = {};
  std::optional<PathPlan> path = {};  ///< then there is neither `end` nor events
};

/// The progress of the run; together with the plan, all that is needed to continue exactly.
struct StepProgress {
  std::int64_t nominal = 0;  ///< nominal steps (adaptive: intervals) completed
  double time = 0.0;         ///< end of the last accepted step [s]
  double limit = 0.0;        ///< upper limit of the next step; with adaptive steps the wanted length [s]
  bool at_event = false;     ///< the last accepted step ended at an event
  bool at_interval = false;  ///< ... at the end of a nominal step or interval
  // Adaptive steps only:
  double last_dt = 0.0;  ///< length of the last accepted step; 0 at the start and after an event [s]
  double error = 0.0;    ///< of the last step with an estimate, relative to what it may have; 0: none
  int rejections = 0;    ///< since the last accepted step
  // The last step rejected for its error, until one as long is accepted; 0: none.
  double rejected_dt = 0.0;     ///< [s]
  double rejected_error = 0.0;  ///< in units of the tolerance
  double wanted = 0.0;          ///< length wanted before the first of these rejections [s]
  double spent = 0.0;           ///< sum of the errors of the accepted steps, in units of the tolerance
  int num_after_start = 0;      ///< accepted steps since the start or the last event, counted as far as it matters

  void keep(Archive& archive);
};

enum class Retry { again, give_up };

struct RetryDecision {
  Retry retry = Retry::again;
  std::string reason;  ///< the reason, for the log
};

/// The progress of a run under a plan with another step, end or interval: the nominal steps completed are those whose
/// ends lie behind. An unchanged plan keeps its progress.
StepProgress under_plan(const StepPlan& plan, StepProgress progress);

/// Fixed nominal step with retry. A failed step is halved, and again; after a success the step at most doubles until it
/// is back at the nominal one. Every time origin + n dt is hit, computed by multiplication so that it carries no
/// accumulated rounding, and so is the end: the last step is shortened where the end is not a multiple of the step, or
/// longer by a millionth of it, so that no sliver remains. So are the events on the way; a nominal time within half a
/// millionth of dt of an event is that event.
///
/// Adaptive steps keep the error of the run near the tolerance by allowing each step its share dt / (end - origin). The
/// way to the next time that must be hit is cut into equal steps, as many as the wanted length asks for: so no sliver
/// arises, and a step that a target cut short does not shorten those after it. The length stays, to the last bit, as
/// long as no considerable change is called for, because factorizations and weights hold for one length. After an event
/// steps start small, as nothing is known of what follows.
///
/// Where an error does not fall as the method's order promises when a step is cut, at a kink or a jump that is not an
/// event, or where the solver's tolerance is all that is left, its share of the run would ask for steps without end.
/// Such a step may take a hundredth of what is unspent: of the tolerance once more, and of what earlier steps left of
/// their shares. So the estimates add up to twice the tolerance at most. At the smallest step an error that hardly
/// falls at all is a jump's, or the solver's: the run continues, and says so.
///
/// Along a path whoever follows it says how long the next step should be, and when it ends. A failed step is halved, as
/// a nominal one is. A value: copies are independent.
class StepControl {
 public:
  /// Starts at the plan's origin.
  explicit StepControl(const StepPlan& plan);
  /// Continues.
  StepControl(const StepPlan& plan, const StepProgress& progress);

  bool finished() const { return progress_.nominal >= num_nominal_; }
  /// The step to try. Not when finished.
  Step next() const;
  /// Whether `next()` may be accepted with this error, in units of the tolerance for the whole run. Nominal steps
  /// always.
  bool accepts(double error) const;
  /// Why `next()` is accepted although its error is too large, in plain words for a warning; empty if it is not.
  std::string concession(double error) const;
  /// The step `next()` was accepted. Nominal steps have no use for the error.
  void accept(double error = 0.0);
  /// A step along a path was accepted that ends there; the next one should be this much longer.
  void accept_on_path(double end, double growth);
  /// Ends a path.
  void stop();
  /// The step `next()` failed for the reason given: `next()` is shorter now, unless the decision is to give up.
  RetryDecision reject(const std::string& reason);
  /// The step `next()` is not accepted for its error. Adaptive steps only.
  RetryDecision reject_error(double error);

  /// The last accepted step ended at an event, or met a jump: past states say nothing about what follows.
  bool at_event() const { return progress_.at_event; }
  /// There is an event of the plan where the next step starts.
  bool starts_at_event() const;
  /// The last accepted step ended at a nominal time or interval, or at the end.
  bool at_interval() const { return progress_.at_interval; }

  const StepProgress& progress() const { return progress_; }
  /// Nominal steps (adaptive: intervals) from the origin to the end.
  std::int64_t num_nominal() const { return num_nominal_; }

 private:
  /// A time that must be hit.
  struct Target {
    double time = 0.0;
    bool is_event = false, is_nominal = false;
  };
  Target target() const;
  double nominal_time(std::int64_t n) const;
  Step next_nominal(const Target& target) const;
  Step next_adaptive(const Target& target) const;
  double allowance(const Step& step, bool is_hard) const;
  double share(const Step& step, double error) const;
  double order_of_share(const Step& step) const;
  bool falls_as_it_should(const Step& step, double error) const;
  bool stands_still(const Step& step, double error) const;
  std::string error_of(const Step& step, double error) const;
  void adapt(const Step& step, double error);
  RetryDecision shorten(const Step& step, double dt, const std::string& failure);
  std::string quantity(double value) const;

  StepPlan plan_;
  std::int64_t num_nominal_ = 0;
  StepProgress progress_;
};

}  // namespace pliant
