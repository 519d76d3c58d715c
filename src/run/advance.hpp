/// Advances the state from one step to the next: by Pliant's integrators, PETSc's, or load steps.
#pragma once

#include "input/config.hpp"
#include "model/model.hpp"
#include "run/critical_point.hpp"
#include "run/ledger.hpp"
#include "solver/newton.hpp"
#include "time/integrator.hpp"

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace pliant {

/// What follows a simulation from stage to stage: the runs of neighbouring inputs (study/tangent_run.hpp). All methods
/// are collective.
class StageFollower {
 public:
  virtual ~StageFollower() = default;
  /// The simulation tries this step from its last accepted state.
  virtual void begin_step(const Step& step) = 0;
  /// The solver has just solved this stage of it; q is the configuration.
  virtual void end_stage(NewtonSolver& solver, const StagePoint& stage, Vec q) = 0;
  /// The step was accepted. `restarts`: the next one starts anew (Advance::restart).
  virtual void end_step(bool restarts) = 0;
};

/// Where the stages of a simulation are solved.
enum class Stages {
  solved_here,      ///< by a solver of its own
  solved_elsewhere  ///< and given to it, one by one: it has no solver
};

/// What a step along a path has met (`time.path`).
struct PathFinding {
  std::optional<PetscInt> unstable_modes;  ///< negative eigenvalues of the tangent stiffness, if they are known
  std::optional<CriticalPoint> critical;   ///< that the step has passed
  double growth = 1.0;                     ///< the next step should be this much longer
  bool is_at_end = false;                  ///< the load factor is at its maximum, or minimum
};

/// A step's outcome is only a proposal until it is accepted. All methods are collective.
class Advance {
 public:
  virtual ~Advance() = default;

  /// Tries a step from the last accepted state. The data that the attempt points to are valid until the next attempt.
  virtual StepAttempt attempt(const Step& step) = 0;
  virtual void accept(const StepAttempt& attempt) = 0;
  /// Starts anew after loads or prescribed velocities may have jumped: the next step uses no history before the last
  /// accepted state, and the velocity becomes that after the jump.
  virtual void restart() {}
  /// Adds to the works of all past states: the loads have changed (Ledger::book_change).
  virtual void shift_works(std::span<const double> /*change*/) {}
  /// Estimated error of a converged attempt in units of the tolerances; 0 if errors are not estimated.
  virtual double error(const StepAttempt& /*attempt*/) const { return 0.0; }

  /// A step stage by stage, with solutions that are found elsewhere: `begin`, for each stage `start_stage` and
  /// `end_stage`, then `end_step`, in place of `attempt`. PETSc's integrators do not take such steps.
  virtual void begin(const Step& step);
  /// The next stage, valid until the next call; sets `unknown` to `guess` with its prescribed entries at their values.
  virtual const StagePoint& start_stage(Vec guess);
  virtual Vec unknown() const;
  /// `unknown` is the solution.
  virtual void end_stage();
  virtual StepAttempt end_step();

  /// Calls the follower's `end_stage` after each stage.
  virtual void follow(StageFollower& /*follower*/) {}

  /// What the last converged attempt along a path has met, or its start; nullptr if there is no path.
  virtual const PathFinding* path() const { return nullptr; }

  /// The formulas of the last step that was tried; nullptr for load steps and PETSc's integrators.
  virtual const Stepper* stepper() const { return nullptr; }

  /// The last accepted state.
  virtual StateView state() const = 0;
  /// Keeps all data on which the following steps depend.
  virtual void keep(Archive& archive) = 0;
  /// Forgets data that only make the following steps faster; these then do not depend on them even in the last digits.
  virtual void forget() {}

  /// Information on the stage at which the last attempt failed; nullopt for PETSc's integrators. Leaves pressures that
  /// are unknowns at that stage. Collective.
  virtual std::optional<FailedStage> examine() { return std::nullopt; }

  /// Makes each iteration of Newton's method call `watcher`; PETSc's integrators ignore it.
  virtual void watch(std::function<void(const StageProgress&)> /*watcher*/) {}

  virtual const SolverStatistics& solver_statistics() const = 0;
  /// A description of the method for the log, line by line.
  virtual std::vector<std::string> description() const = 0;
};

/// Makes the Advance for the input's method, from the initial state. `config`, `model` and `ledger` outlive the result.
std::unique_ptr<Advance> make_advance(const Config& config, Model& model, Ledger& ledger, const StateView& initial,
                                      Stages stages);

}  // namespace pliant
