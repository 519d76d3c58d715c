/// The stages of a run, kept to go back through them.
#pragma once

#include "petsc/kept_in_memory.hpp"
#include "run/simulation.hpp"

#include <cstdint>
#include <memory>
#include <vector>

namespace pliant {

/// A stage that was solved, with copies of what its StagePoint refers to.
struct RecordedStage {
  StagePoint point;
  Handle<Vec> q;  ///< its solution
  Handle<Vec> q0, v0;
  Handle<Vec> z0;  ///< null if there are no internal variables
};

/// An accepted step.
struct RecordedStep {
  std::int64_t number = 0;  ///< of the state at its end
  Step step;
  const Method* method = nullptr;  ///< nullptr: a load step
  BdfWeights weights;
  bool restarts = false;  ///< the next step starts anew
  Handle<Vec> end_q;      ///< q_{n+1} where no stage is there and internal variables depend on it
  std::vector<RecordedStage> stages;

  /// The configuration at its end; internal variables are functions of it.
  Vec end() const { return end_q ? end_q.get() : stages.back().q.get(); }
};

/// Keeps the accepted steps of a simulation, the last ones of it. All methods are collective.
class StepRecording final : public StageFollower {
 public:
  /// Follows the simulation, which outlives the object.
  explicit StepRecording(Simulation& simulation) : simulation_(simulation) { simulation.follow(*this); }

  const std::vector<RecordedStep>& steps() const { return steps_; }
  void clear() { steps_.clear(); }
  /// Memory of a step on this rank [bytes]; 0 before the first.
  double bytes_per_step() const { return bytes_; }
  /// The solver of the simulation; nullptr before the first stage.
  NewtonSolver* solver() const { return solver_; }

  void begin_step(const Step& step) override;
  void end_stage(NewtonSolver& solver, const StagePoint& stage, Vec q) override;
  void end_step(bool restarts) override;

 private:
  Simulation& simulation_;
  NewtonSolver* solver_ = nullptr;
  RecordedStep tried_;
  std::vector<RecordedStep> steps_;
  double bytes_ = 0.0;
};

/// What a simulation keeps (Simulation::keep), in memory.
class StateInMemory {
 public:
  /// Collective.
  explicit StateInMemory(Simulation& simulation) : kept_([&](Archive& archive) { simulation.keep(archive); }) {}
  /// Collective.
  void restore(Simulation& simulation) const {
    kept_.restore([&](Archive& archive) { simulation.keep(archive); });
  }

 private:
  KeptInMemory kept_;
};

}  // namespace pliant
