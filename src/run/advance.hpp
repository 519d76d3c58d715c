/// What moves the state from one step to the next: our integrators, PETSc's, or load steps.
#pragma once

#include "input/config.hpp"
#include "model/model.hpp"
#include "run/ledger.hpp"
#include "solver/newton.hpp"
#include "time/integrator.hpp"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// A step's outcome is only a proposal until it is accepted. All methods are collective.
class Advance {
 public:
  virtual ~Advance() = default;

  /// Tries a step from the last accepted state. What the attempt points to is valid until the next one.
  virtual StepAttempt attempt(const Step& step) = 0;
  virtual void accept(const StepAttempt& attempt) = 0;
  /// Loads or given velocities may have jumped: what was before the last accepted state is of no use to the next step,
  /// and the velocity becomes that after the jump.
  virtual void restart() {}
  /// Estimated error of a converged attempt in units of the tolerances; 0 if errors are not estimated.
  virtual double error(const StepAttempt& /*attempt*/) const { return 0.0; }

  /// The last accepted state.
  virtual StateView state() const = 0;
  /// What the steps that follow depend on.
  virtual void keep(Archive& archive) = 0;
  /// Forgets what only makes the following steps faster, so that they do not depend on it even in the last digits.
  virtual void forget() {}

  /// What is known of the stage at which the last attempt failed; nothing of PETSc's integrators. Leaves the pressures
  /// that are unknowns at that stage. Collective.
  virtual std::optional<FailedStage> examine() { return std::nullopt; }

  /// Calls `watcher` at each iteration of Newton's method; PETSc's integrators do not.
  virtual void watch(std::function<void(const StageProgress&)> /*watcher*/) {}

  virtual const SolverStatistics& solver_statistics() const = 0;
  /// How it works, line by line, for the log.
  virtual std::vector<std::string> description() const = 0;
};

/// The linear solver that the input asks for, or leaves to us.
LinearKind linear_kind(const Config& config, const NodeLayout& layout);

/// What the input's method asks for, from the initial state. `config`, `model` and `ledger` outlive the result.
std::unique_ptr<Advance> make_advance(const Config& config, Model& model, Ledger& ledger, const StateView& initial);

}  // namespace pliant
