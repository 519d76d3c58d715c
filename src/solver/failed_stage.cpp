// What NewtonSolver tells of a stage that it could not solve.
#include "solver/failed_stage.hpp"

#include "petsc/array_view.hpp"
#include "solver/newton.hpp"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

/// Lengths on either side of the profile: 1, and each time shorter by the square root of ten.
constexpr int num_lengths = 10;

/// The part of the unknowns' vector that belongs to displacements, like `displacements`.
Handle<Vec> part_of_displacements(Vec unknowns, Vec displacements) {
  Handle<Vec> part;
  check(VecDuplicate(displacements, part.out()));
  const ConstArrayView from(unknowns);
  const ArrayView to(part.get());
  std::copy_n(from.span().begin(), to.span().size(), to.span().begin());
  return part;
}

Handle<Vec> copy_of(Vec x) {
  Handle<Vec> copy;
  check(VecDuplicate(x, copy.out()));
  check(VecCopy(x, copy.get()));
  return copy;
}

}  // namespace

void NewtonSolver::note_iteration(PetscInt iteration, double residual) {
  if (iteration == 0) iterations_.clear();
  NewtonIteration now;
  now.residual = residual;
  if (iteration > 0) {
    SNESLineSearch search = nullptr;
    KSP ksp = nullptr;
    PetscInt linear_iterations = 0;
    check(SNESGetLineSearch(snes_.get(), &search));
    check(SNESLineSearchGetLambda(search, &now.step_length));
    check(SNESGetKSP(snes_.get(), &ksp));
    check(KSPGetIterationNumber(ksp, &linear_iterations));
    now.linear_iterations = static_cast<int>(linear_iterations);
    if (projection_ != Projection::none) now.hessian = NewtonIteration::Hessian::projected;
    if (is_regularized_) now.hessian = NewtonIteration::Hessian::shifted;
  }
  iterations_.push_back(now);
  if (!watcher_) return;
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start_of_stage_;
  watcher_({seconds.count(), static_cast<int>(iteration), residual, target(), now.linear_iterations});
}

void NewtonSolver::note_failure(const StagePoint& stage, Vec q) {
  failed_at_ = copy_of(q);
  failed_time_ = stage.time;
  failed_dt_ = stage.dt;
}

std::optional<FailedStage> NewtonSolver::examine() {
  if (!failed_at_) return std::nullopt;
  Vec q = failed_at_.get();
  FailedStage stage;
  stage.time = failed_time_;
  stage.dt = failed_dt_;
  stage.tolerance = target();
  stage.force_scale = scale_;
  stage.rounding_floor = equation_.rounding_floor(q);
  stage.lacks_memory = lacks_memory_;
  stage.iterations = iterations_;
  stage.measure = path_ == Path::minimisation ? FailedStage::Measure::potential : FailedStage::Measure::merit;
  stage.displacement = copy_of(equation_.displacements(q));
  Vec u = stage.displacement.get();
  check(VecDuplicate(u, stage.direction.out()));
  check(VecSet(stage.direction.get(), 0.0));
  equation_.gradient(q, r_.get());
  stage.residual = part_of_displacements(r_.get(), u);
  if (!has_direction_) return stage;

  Vec y = nullptr;
  check(SNESGetSolutionUpdate(snes_.get(), &y));
  PetscReal size = 0.0;
  check(VecNorm(y, NORM_2, &size));
  if (!std::isfinite(size) || size == 0.0) return stage;
  const Handle<Vec> d = copy_of(y), trial = copy_of(q);
  check(VecScale(d.get(), -1.0));
  if (path_ == Path::minimisation) {
    PetscScalar slope = 0.0;
    check(VecDot(r_.get(), d.get(), &slope));
    stage.slope = slope;
  }
  stage.inversion = equation_.max_step(q, d.get());
  check(VecAXPY(trial.get(), 1.0, d.get()));
  check(VecWAXPY(stage.direction.get(), -1.0, u, equation_.displacements(trial.get())));
  const double here = height(q);
  const auto sample = [&](double length) {
    check(VecWAXPY(trial.get(), length, d.get(), q));
    stage.profile.push_back({length, height(trial.get()) - here});
  };
  for (int k = 0; k < num_lengths; ++k) sample(-std::pow(10.0, -0.5 * k));
  stage.profile.push_back({0.0, 0.0});
  for (int k = num_lengths; k-- > 0;) sample(std::pow(10.0, -0.5 * k));
  return stage;
}

}  // namespace pliant
