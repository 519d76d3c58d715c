#include "study/recorded_step.hpp"

#include "petsc/copy_of.hpp"

#include <algorithm>
#include <utility>

namespace pliant {
namespace {

double bytes_of(Vec x) {
  PetscInt size = 0;
  if (x != nullptr) check(VecGetLocalSize(x, &size));
  return static_cast<double>(sizeof(double)) * static_cast<double>(size);
}

}  // namespace

void StepRecording::begin_step(const Step& step) {
  tried_ = {};
  tried_.step = step;
}

void StepRecording::end_stage(NewtonSolver& solver, const StagePoint& stage, Vec q) {
  solver_ = &solver;
  RecordedStage kept{stage, copy_of(q), copy_of(stage.q0), copy_of(stage.v0), copy_of(stage.z0)};
  kept.point.q0 = kept.q0.get();
  kept.point.v0 = kept.v0.get();
  kept.point.z0 = kept.z0.get();
  kept.point.end_rest = kept.point.accepted = kept.point.accepted_z = nullptr;
  kept.point.end_weight = 0.0;
  tried_.stages.push_back(std::move(kept));
}

void StepRecording::end_step(bool restarts) {
  const StepRecord& record = simulation_.record();
  tried_.number = record.step;
  tried_.restarts = restarts;
  if (const Stepper* stepper = simulation_.stepper()) {
    tried_.method = &stepper->method();
    tried_.weights = stepper->weights_of_step();
    if (record.z != nullptr && !tried_.method->stiffly_accurate) tried_.end_q = copy_of(record.q);
  }
  double bytes = bytes_of(tried_.end_q.get());
  for (const RecordedStage& stage : tried_.stages) bytes += 3.0 * bytes_of(stage.q.get()) + bytes_of(stage.z0.get());
  bytes_ = std::max(bytes_, bytes);
  steps_.push_back(std::exchange(tried_, {}));
}

}  // namespace pliant
