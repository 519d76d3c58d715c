// How TS starts: without a history, or with the history of an uninterrupted run.
#include "solver/petsc_integrator.hpp"

#include <cmath>
#include <utility>

namespace pliant {
namespace {

/// Length of a stage, as a fraction of the step, at which M / dt^2 exceeds the rest of the Hessian beyond double
/// precision, whatever the step.
constexpr double short_part_of_step = 1e-30;
/// The constant acceleration, in the two half steps with which TSALPHA2 starts, that it interprets as 1. Before PETSc
/// 3.22 its difference formula gave twice the acceleration, and spectral radii below 1 were of first order.
constexpr double start_acceleration = PETSC_VERSION_LT(3, 22, 0) ? 0.5 : 1.0;

}  // namespace

PetscErrorCode PetscIntegrator::solved_callback(TS ts, PetscReal time, PetscInt, Vec* y) {
  void* self = nullptr;
  const PetscErrorCode code = TSGetApplicationContext(ts, &self);
  if (code != 0) return code;
  auto* integrator = static_cast<PetscIntegrator*>(self);
  if (!integrator->is_bdf() || !integrator->points_.empty() || integrator->num_stages_ != 1) return 0;
  return integrator->guard_.run([&] {
    State& middle = integrator->middle_;
    split(*y, middle.q.get(), middle.v.get());
    middle.time = time;
  });
}

void PetscIntegrator::find_acceleration() {
  if (!mass_) {
    mass_ = equation_.make_hessian();
    const Handle<Vec> zero = equation_.make_vector();
    // A power of two gives M the same bits for every step.
    const double instant = std::ldexp(1.0, std::ilogb(short_part_of_step * time_step()));
    (void)equation_.enter({.time = stage_.time, .dt = instant, .q0 = zero.get(), .v0 = zero.get()}, zero.get(),
                          unknowns_.get());
    equation_.hessian(zero.get(), mass_.get(), Projection::none);
    check(MatScale(mass_.get(), instant * instant));
    check(KSPCreate(equation_.comm(), mass_solver_.out()));
    KSP ksp = mass_solver_.get();
    check(KSPSetOptionsPrefix(ksp, "mass_"));
    check(KSPSetOperators(ksp, mass_.get(), mass_.get()));
    check(KSPSetType(ksp, KSPCG));
    PC pc = nullptr;
    check(KSPGetPC(ksp, &pc));
    check(PCSetType(pc, PCJACOBI));
    check(KSPSetTolerances(ksp, 1e-13, 0.0, PETSC_DEFAULT, 1000));
    check(KSPSetFromOptions(ksp));
  }
  check(VecScale(r_.get(), -1.0));
  check(KSPSolve(mass_solver_.get(), r_.get(), a_.get()));
}

void PetscIntegrator::find_start() {
  if (!is_acceleration_recorded_) {
    check(VecZeroEntries(a_.get()));
    begin_stage(accepted_.time, time_step(), accepted_.q.get(), accepted_.v.get(), a_.get());
    evaluate_forces();
    find_acceleration();
    check(VecCopy(a_.get(), acceleration_.get()));
  }
  check(VecCopy(accepted_.v.get(), start_v_.get()));
}

void PetscIntegrator::record_acceleration(double dt) {
  // v1 = v0 + dt ((1 - gamma) a0 + gamma a1); TS gives access to all but the accelerations.
  PetscReal gamma = 0.0;
  check(TSAlpha2GetParams(ts_.get(), nullptr, nullptr, &gamma, nullptr));
  check(VecWAXPY(end_a_.get(), -1.0, accepted_.v.get(), y_dot_.get()));
  check(VecAXPBY(end_a_.get(), -(1.0 - gamma) / gamma, 1.0 / (gamma * dt), acceleration_.get()));
}

void PetscIntegrator::hand_over_points() {
  TS ts = ts_.get();
  for (std::size_t n = 2; n < points_.size(); ++n) {
    const State& from = points_[n - 1];
    set_solution(from.q.get(), from.v.get());
    check(TSSetTime(ts, from.time));
    // The first step also solves for its middle.
    check(TSSetTimeStep(ts, points_[n].time - from.time));
    num_stages_ = 0;
    handed_ = n;
    guard_.rethrow(TSStep(ts));
  }
  handed_ = 0;
}

void PetscIntegrator::hand_over(Vec x) {
  if (handed_ != 0) {
    const State& point = points_[handed_ == 2 && num_stages_ == 1 ? 0 : handed_];
    join(point.q.get(), point.v.get(), x);
    return;
  }
  const double dt = time_step();
  check(VecAXPBYPCZ(x, dt, 0.5 * start_acceleration * dt * dt, 1.0, start_v_.get(), acceleration_.get()));
  check(VecAXPY(start_v_.get(), start_acceleration * dt, acceleration_.get()));
}

void PetscIntegrator::keep(Archive& archive) {
  accepted_.keep(archive);
  archive.number("num_accepted", num_accepted_);
  archive.number("is_acceleration_recorded", is_acceleration_recorded_);
  if (is_acceleration_recorded_) archive.vector("acceleration", Entries::nodes, acceleration_.get());
  const Archive::Section section(archive, "points");
  points_.keep(archive, accepted_.view());
  if (archive.restores()) starts_ = true;
}

void PetscIntegrator::forget() {
  if (is_tried_) roll_back();
  starts_ = true;
}

void PetscIntegrator::restart() {
  forget();
  points_.forget();
  is_acceleration_recorded_ = false;
  motion_.restart({accepted_.time, time_step()}, accepted_.q.get(), accepted_.v.get());
  set_solution(accepted_.q.get(), accepted_.v.get());
}

}  // namespace pliant
