/// A problem in motion: solver, integrator, control of the steps and ledger on a model; no output.
#pragma once

#include "input/config.hpp"
#include "model/model.hpp"
#include "run/advance.hpp"
#include "run/ledger.hpp"
#include "solver/newton.hpp"
#include "time/step_control.hpp"

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>

namespace pliant {

/// A completed step, or the initial state (step 0).
struct StepRecord {
  std::int64_t step = 0;
  double time = 0.0;  ///< [s]; of a static problem the load factor
  double dt = 0.0;    ///< likewise
  int newton_iterations = 0;
  int linear_iterations = 0;
  Vec q = nullptr;
  Vec v = nullptr;
  Vec a = nullptr;    ///< nullptr: zero
  Vec z = nullptr;    ///< internal variables; nullptr if there are none
  Closeness contact;  ///< at its end, if there are obstacles
};

/// What came of trying a step.
struct StepOutcome {
  enum class Kind {
    accepted,
    inaccurate,  ///< the next one is shorter
    unsolved,    ///< the next one is shorter
    failed       ///< there is no way on
  };
  Kind kind = Kind::accepted;
  std::string reason;  ///< of a step that was not accepted, or only for want of a better one, in plain words
  Step tried;
  bool is_mistake = false;  ///< a formula of the input is no number there
};

/// What all the steps took.
struct StepStatistics {
  std::int64_t accepted = 0;
  std::int64_t failed = 0;      ///< not solved, tried again shorter
  std::int64_t inaccurate = 0;  ///< solved, but above the tolerance, tried again shorter
  double shortest = 0.0;        ///< [s]
  double longest = 0.0;         ///< [s]
  /// To obstacles at the end of any step of this process, Closeness::gap [m].
  double least_gap = std::numeric_limits<double>::infinity();
};

/// All methods are collective.
class Simulation {
 public:
  /// Starts from the input's initial state. `model` and `config` outlive the object; the model's terms are set up for
  /// the method of `config`. Throws InputError where the initial state or a PETSc option is wrong.
  Simulation(const Config& config, Model& model);
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  bool finished() const { return control_->finished(); }
  /// Tries one step.
  StepOutcome advance();

  /// The last completed step; its acceleration is known until the next one is tried.
  const StepRecord& record() const { return record_; }
  const StepPlan& plan() const { return plan_; }
  const Ledger& ledger() const { return *ledger_; }
  Analysis analysis() const { return analysis_; }
  /// Of our own solver, or of PETSc's integrator as far as it tells.
  const SolverStatistics& solver_statistics() const { return advance_->solver_statistics(); }
  const StepStatistics& steps() const { return steps_; }
  /// All that the following steps depend on. After restoring, a changed step and end of `config` are followed.
  void keep(Archive& archive);
  /// Forgets what only makes the following steps faster: they come out the same, to the last bit on the same ranks, as
  /// after restoring what is kept now.
  void forget() { advance_->forget(); }

  /// Advance::watch.
  void watch(std::function<void(const StageProgress&)> watcher) { advance_->watch(std::move(watcher)); }

  /// What is known of the last attempt's failure; the last thing to ask of a simulation, whose pressures it changes.
  std::optional<FailedStage> examine() { return advance_->examine(); }

  /// How equations are solved and time advances, line by line, for the log.
  std::vector<std::string> description() const { return advance_->description(); }

 private:
  void set_plan(const Config& config);
  /// What to say of a converged attempt whose end no body can have reached.
  std::optional<std::string> impossibility(const StepAttempt& attempt, const Step& step);
  /// What to say of an impact on a barrier that gains energy in a step which may still be cut.
  std::optional<std::string> gain_at_barrier(const StepAttempt& attempt, const Step& step);
  /// Whether a tetrahedron is inside out at the end of the step, where no stage is.
  bool ends_inside_out(const StepAttempt& attempt);
  StepOutcome reject(const StepAttempt& attempt, const Step& step);
  void accept(const StepAttempt& attempt, const Step& step);
  /// Measures `contact` of the state in `q_`, and keeps that with its ghosts.
  void measure_contact();
  /// Whether the next step would make more of an impact in this one, which was accepted, than there was.
  bool extrapolates_impact(const Step& step, bool touches);
  /// What to say of a body that a converged attempt takes through an obstacle.
  std::optional<std::string> passage(const StepAttempt& attempt);

  Analysis analysis_;
  int num_past_ = 1;  // states that the method takes; of PETSc's, which may be a multistep method, 2
  Model& model_;
  Handle<Vec> q_, v_;
  Handle<Vec> next_q_;  // of an attempt, with its ghosts
  StepPlan plan_;
  std::optional<Ledger> ledger_;
  std::unique_ptr<Advance> advance_;
  std::optional<StepControl> control_;
  StepRecord record_;
  StepStatistics steps_;
  double contact_start_ = 0.0;  // end of the last step without contact [s]
  std::int64_t steps_since_restart_ = 0;
};

}  // namespace pliant
