/// A simulation in progress: solver, integrator, step control and ledger on a model, without output.
#pragma once

#include "input/config.hpp"
#include "model/model.hpp"
#include "run/advance.hpp"
#include "run/ledger.hpp"
#include "run/path_end.hpp"
#include "run/turn_watch.hpp"
#include "solver/newton.hpp"
#include "time/step_control.hpp"

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>

namespace pliant {

/// A completed step, or the initial state (step 0).
struct StepRecord {
  std::int64_t step = 0;
  double time = 0.0;  ///< [s]; in a static problem, the load factor, or the length of its path
  double dt = 0.0;    ///< likewise
  int newton_iterations = 0;
  int linear_iterations = 0;
  Vec q = nullptr;                              ///< with its ghosts
  Vec v = nullptr;                              ///< likewise
  Vec a = nullptr;                              ///< nullptr: zero
  Vec z = nullptr;                              ///< internal variables; nullptr if there are none
  Closeness contact;                            ///< at the step's end, if there are obstacles
  double load_factor = 1.0;                     ///< of a static problem
  std::optional<PetscInt> unstable_modes = {};  ///< PathFinding, of the step
  std::optional<CriticalPoint> critical = {};   ///< likewise

  /// What terms know about its end.
  Instant instant(const Model& model) const { return model.instant(time, load_factor); }
};

/// The outcome of trying a step.
struct StepOutcome {
  enum class Kind {
    accepted,
    inaccurate,  ///< the next attempt is shorter
    unsolved,    ///< the next attempt is shorter
    failed       ///< the simulation cannot continue
  };
  Kind kind = Kind::accepted;
  std::string reason;  ///< why a step was not accepted, or only for lack of a better one; for the user
  Step tried;
  bool is_input_error = false;  ///< a formula of the input is not a finite number there
};

/// Statistics of all steps.
struct StepStatistics {
  std::int64_t accepted = 0;
  std::int64_t failed = 0;      ///< not solved, repeated with a shorter step
  std::int64_t inaccurate = 0;  ///< solved, but above the tolerance; repeated with a shorter step
  double shortest = 0.0;        ///< [s]
  double longest = 0.0;         ///< [s]
  /// Smallest gap to obstacles at the end of any step of this process (Closeness::gap) [m].
  double least_gap = std::numeric_limits<double>::infinity();
};

/// Whether the ledger of a simulation is kept. Where it is not, energies, works and reactions stay those of the start.
enum class Books { kept, none };

/// All methods are collective.
class Simulation {
 public:
  /// Starts from the input's initial state. `config` is that of the model, but for its output; both outlive the object.
  /// Throws InputError if the initial state or a PETSc option is wrong.
  Simulation(const Config& config, Model& model, Stages stages = Stages::solved_here, Books books = Books::kept);
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;
  ~Simulation();

  bool finished() const { return control_->finished(); }
  /// Tries one step.
  StepOutcome advance();
  /// Tries steps until one is accepted, or the simulation cannot continue; calls `retried` for each that is not.
  StepOutcome complete_step(const std::function<void(const StepOutcome&)>& retried = {});
  /// A failure in words: "the solve failed at t = 0.1: ...".
  std::string in_words(const StepOutcome& failure) const;
  /// The step that the next call tries first.
  Step next_step() const { return control_->next(); }
  /// After a failure: forgets the attempts since the last accepted step, so that the next one is tried at full length.
  void forget_attempts() { control_.emplace(plan_, accepted_); }
  /// The formulas of the model have been replaced: books what that changes.
  void take_changes() { advance_->shift_works(ledger_->book_change(advance_->state())); }
  /// Plans the steps from here on by another input: its steps, and the kinks of its formulas.
  void plan_anew(const Config& config);

  /// Calls the follower at each step and stage from now on; it outlives the simulation.
  void follow(StageFollower& follower);
  /// Advance::stepper.
  const Stepper* stepper() const { return advance_->stepper(); }
  /// A step that another simulation takes too, stage by stage, with solutions that are found elsewhere
  /// (Advance::begin). It is accepted as it is.
  void begin(const Step& step);
  const StagePoint& start_stage(Vec guess) { return advance_->start_stage(guess); }
  Vec unknown() const { return advance_->unknown(); }
  void end_stage() { advance_->end_stage(); }
  void end_step(bool restarts);

  /// The last completed step; its acceleration is known until the next one is tried.
  const StepRecord& record() const { return record_; }
  const StepPlan& plan() const { return plan_; }
  /// Why the path ended; empty if it has not.
  const std::string& end_of_path() const { return end_of_path_; }
  const Ledger& ledger() const { return *ledger_; }
  Analysis analysis() const { return analysis_; }
  /// Statistics of Pliant's solver, or those that PETSc's integrator reports.
  const SolverStatistics& solver_statistics() const { return advance_->solver_statistics(); }
  const StepStatistics& steps() const { return steps_; }
  /// Keeps all data on which the following steps depend. After restoring, a changed step and end in `config` take
  /// effect.
  void keep(Archive& archive);
  /// Velocities may jump here, as prescribed motion does: the next step starts anew from those that are allowed.
  void restart();
  /// Forgets data that only make the following steps faster. These are then identical, to the last bit on the same
  /// ranks, to the steps after restoring the state kept now.
  void forget() { advance_->forget(); }

  /// Advance::watch.
  void watch(std::function<void(const StageProgress&)> watcher) { advance_->watch(std::move(watcher)); }

  /// Information on the last attempt's failure. To be called last, because it changes the pressures.
  std::optional<FailedStage> examine() { return advance_->examine(); }

  /// A description of solver and time integration for the log, line by line.
  std::vector<std::string> description() const { return advance_->description(); }

 private:
  void set_plan(const Config& config);
  /// Whether the path has ended.
  bool path_has_ended();
  /// Shortens the next step until prescribed rotations can be followed in it. An outcome if that is news, or fails.
  std::optional<StepOutcome> shorten_turn();
  /// Continues under the present plan from the progress under one with this step.
  void continue_control(StepProgress progress, double former_step);
  /// A message if no body can have reached the end of a converged attempt.
  std::optional<std::string> impossibility(const StepAttempt& attempt, const Step& step);
  /// A message if an impact on a barrier gains energy in a step that may still be shortened.
  std::optional<std::string> gain_at_barrier(const StepAttempt& attempt, const Step& step);
  /// A message if a step without inertia ends farther away than any body can lie.
  std::optional<std::string> escape(const StepAttempt& attempt);
  /// Whether a tetrahedron is inverted at the end of the step, which is not a stage.
  bool ends_inside_out(const StepAttempt& attempt);
  StepOutcome reject(const StepAttempt& attempt, const Step& step);
  /// What the growth of displacements says about loads beyond the last state; may be empty.
  std::string limit_in_sight() const;
  void accept(const StepAttempt& attempt, const Step& step);
  /// Makes q and v the record's. Collective.
  void take_state(Vec q, Vec v);
  /// Measures `contact` of the state in `q_`.
  void measure_contact();
  /// Whether the next step would amplify an impact in this step, which was accepted.
  bool extrapolates_impact(const Step& step, bool touches);
  /// A message if a converged attempt takes a body through an obstacle.
  std::optional<std::string> passage(const StepAttempt& attempt);
  /// Contacts::limit_steps, for the steps that follow one that failed.
  void limit_steps(bool is_limited);

  Analysis analysis_;
  Books books_;
  int num_past_ = 1;  // states that the method uses; 2 for PETSc's, which may be multistep methods
  Model& model_;
  Handle<Vec> q_, v_;
  Handle<Vec> next_q_;  // of an attempt, with its ghosts
  StepPlan plan_;
  std::optional<Ledger> ledger_;
  std::unique_ptr<Advance> advance_;
  std::optional<StepControl> control_;
  std::unique_ptr<PathEnd> path_end_;  // nullptr without a path
  std::string end_of_path_;
  StepProgress accepted_;  // at the last accepted step
  StepRecord record_;
  StepStatistics steps_;
  TurnWatch turns_;
  bool warned_of_turns_ = false;
  bool only_contact_holds_ = false;
  bool may_go_far_ = false;  // there are mechanisms, which formulas carry along, or bodies without a size
  double moved_ = 0.0;       // by the last attempt without inertia, any node [m]
  // By all accepted steps without inertia, in which load factor or time has grown by that much, and by the last one.
  double moved_in_all_ = 0.0, grown_ = 0.0, last_growth_ = 0.0;
  double contact_start_ = 0.0;      // end of the last step without contact [s]
  bool settles_pressures_ = false;  // because steps do not end with a stage
  std::int64_t steps_since_restart_ = 0;
  Step step_;  // that is taken stage by stage
  StageFollower* follower_ = nullptr;
};

}  // namespace pliant
