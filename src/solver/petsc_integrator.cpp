#include "solver/petsc_integrator.hpp"

#include "petsc/array_view.hpp"
#include "solver/merit.hpp"

#include <cassert>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace pliant {
namespace {

constexpr int most_cuts = 20;
/// The residual's rounding floor is an estimate: an iterate below `floor_factor` times the floor is accepted, and one
/// up to 100 times that if the residual no longer falls.
constexpr double floor_factor = 4.0;

}  // namespace

PetscIntegrator::PetscIntegrator(const PetscIntegratorOptions& options, StageEquation& equation,
                                 PrescribedMotion motion, const StateView& initial)
    : options_(options),
      equation_(equation),
      motion_(std::move(motion)),
      accepted_(initial),
      end_(initial),
      middle_(initial) {
  for (Handle<Vec>* x :
       {&q0_, &v0_, &q_, &unknowns_, &r_, &q_part_, &v_part_, &rate_, &a_, &start_v_, &acceleration_, &end_a_}) {
    *x = equation.make_vector();
  }
  check(TSCreate(equation.comm(), ts_.out()));
  configure_time_stepping();
  configure_newton();
}

void PetscIntegrator::configure_time_stepping() {
  TS ts = ts_.get();
  check(TSSetType(ts, options_.method.type.data()));
  check(TSSetApplicationContext(ts, this));
  check(TSSetPreStage(ts, stage_callback));
  check(TSSetPostStage(ts, solved_callback));
  if (is_second_order()) {
    K_ = equation_.make_hessian();
    y_ = equation_.make_vector();
    y_dot_ = equation_.make_vector();
    check(TSSetI2Function(ts, nullptr, second_order_residual, this));
    check(TSSetI2Jacobian(ts, K_.get(), K_.get(), second_order_jacobian, this));
    check(TS2SetSolution(ts, y_.get(), y_dot_.get()));
  } else {
    system_ = std::make_unique<ReducedSystem>(equation_, options_.linear);
    y_ = make_state_vector(q_.get());
    check(TSSetIFunction(ts, nullptr, first_order_residual, this));
    check(TSSetIJacobian(ts, system_->matrix(), system_->matrix(), first_order_jacobian, this));
    check(TSSetSolution(ts, y_.get()));
  }
}

void PetscIntegrator::configure_newton() {
  TS ts = ts_.get();
  SNES snes = nullptr;
  check(TSGetSNES(ts, &snes));
  check(SNESSetType(snes, SNESNEWTONLS));
  check(SNESSetComputeInitialGuess(snes, guess_callback, this));
  check(SNESSetConvergenceTest(snes, convergence_callback, this, nullptr));
  // No tolerance on the step: see NewtonSolver.
  check(SNESSetTolerances(snes, PETSC_DEFAULT, PETSC_DEFAULT, 0.0, options_.newton.max_iterations, PETSC_MAX_INT));
  SNESLineSearch search = nullptr;
  check(SNESGetLineSearch(snes, &search));
  check(SNESLineSearchSetType(search, SNESLINESEARCHSHELL));
  check(SNESLineSearchShellSetUserFunc(search, line_search_callback, this));
  KSP ksp = nullptr;
  check(SNESGetKSP(snes, &ksp));
  if (is_second_order()) {
    configure_linear_solver(ksp, K_.get(), options_.linear, equation_.symmetry());
  } else {
    system_->configure(ksp);
  }
  check(TSSetFromOptions(ts));
  // Options that users cannot change: TS takes the steps it is asked for, and the caller repeats failed ones.
  TSType type = nullptr;
  check(TSGetType(ts, &type));
  if (options_.method.type != type) {
    throw PetscFailure(PETSC_ERR_USER,
                       fmt::format("-ts_type {} contradicts the method: petsc: {}", type, options_.method.name));
  }
  TSAdapt adapt = nullptr;
  check(TSGetAdapt(ts, &adapt));
  check(TSAdaptSetType(adapt, TSADAPTNONE));
  check(TSSetMaxSNESFailures(ts, 1));
  check(TSSetErrorIfStepFails(ts, PETSC_FALSE));
  check(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_STEPOVER));
  check(TSSetMaxTime(ts, PETSC_MAX_REAL));
  check(TSSetMaxSteps(ts, PETSC_MAX_INT - 1));
  if (options_.method.kind == PetscMethod::Kind::arkimex) check(TSARKIMEXSetFullyImplicit(ts, PETSC_TRUE));
  if (is_bdf()) {
    PetscInt order = 0;
    check(TSBDFGetOrder(ts, &order));
    points_ = BdfPoints(static_cast<int>(order));
  }
}

double PetscIntegrator::time_step() const {
  PetscReal dt = 0.0;
  check(TSGetTimeStep(ts_.get(), &dt));
  return dt;
}

PetscErrorCode PetscIntegrator::stage_callback(TS ts, PetscReal time) {
  void* self = nullptr;
  const PetscErrorCode code = TSGetApplicationContext(ts, &self);
  if (code != 0) return code;
  auto* integrator = static_cast<PetscIntegrator*>(self);
  integrator->stage_time_ = time;
  ++integrator->num_stages_;
  integrator->is_solving_ = false;
  return 0;
}

PetscErrorCode PetscIntegrator::second_order_residual(TS, PetscReal t, Vec q, Vec v, Vec a, Vec F, void* self) {
  auto* integrator = static_cast<PetscIntegrator*>(self);
  return integrator->guard_.run([&] {
    if (integrator->is_handing_over()) {
      check(VecZeroEntries(F));
      return;
    }
    integrator->begin_stage(t, integrator->time_step(), q, v, a);
    integrator->evaluate_forces();
    check(VecCopy(integrator->r_.get(), F));
  });
}

PetscErrorCode PetscIntegrator::second_order_jacobian(TS, PetscReal t, Vec q, Vec v, Vec a, PetscReal,
                                                      PetscReal shift_a, Mat J, Mat, void* self) {
  auto* integrator = static_cast<PetscIntegrator*>(self);
  return integrator->guard_.run([&] {
    // Exact in mass and stiffness. Viscosity gets the factor 1/dt instead of shift_v: the two are equal at a spectral
    // radius of 1 and differ by at most 6 % (radius 0), which costs at most one iteration.
    integrator->begin_stage(t, 1.0 / std::sqrt(shift_a), q, v, a);
    integrator->equation_.hessian(integrator->unknowns_.get(), J, Projection::none);
  });
}

PetscErrorCode PetscIntegrator::first_order_residual(TS, PetscReal t, Vec y, Vec y_dot, Vec F, void* self) {
  auto* integrator = static_cast<PetscIntegrator*>(self);
  return integrator->guard_.run([&] {
    integrator->is_handing_over() ? check(VecZeroEntries(F)) : integrator->evaluate_first_order(t, y, y_dot, F);
  });
}

PetscErrorCode PetscIntegrator::first_order_jacobian(TS, PetscReal t, Vec y, Vec y_dot, PetscReal shift, Mat, Mat,
                                                     void* self) {
  auto* integrator = static_cast<PetscIntegrator*>(self);
  return integrator->guard_.run([&] {
    split(y_dot, integrator->rate_.get(), integrator->a_.get());
    split(y, integrator->q_part_.get(), integrator->v_part_.get());
    integrator->begin_stage(t, 1.0 / shift, integrator->q_part_.get(), integrator->v_part_.get(), integrator->a_.get());
    integrator->system_->set_shift(shift);
    integrator->equation_.hessian(integrator->unknowns_.get(), integrator->system_->hessian(), Projection::none);
  });
}

PetscErrorCode PetscIntegrator::guess_callback(SNES snes, Vec x, void* self) {
  auto* integrator = static_cast<PetscIntegrator*>(self);
  return integrator->guard_.run([&] { integrator->complete_guess(snes, x); });
}

PetscErrorCode PetscIntegrator::line_search_callback(SNESLineSearch search, void* self) {
  auto* integrator = static_cast<PetscIntegrator*>(self);
  return integrator->guard_.run([&] { integrator->search_line(search); });
}

PetscErrorCode PetscIntegrator::convergence_callback(SNES, PetscInt it, PetscReal, PetscReal, PetscReal f,
                                                     SNESConvergedReason* reason, void* self) {
  auto* integrator = static_cast<PetscIntegrator*>(self);
  return integrator->guard_.run([&] { *reason = integrator->judge(it, f); });
}

double PetscIntegrator::within_step(double time) const {
  constexpr double rounding = 4.0 * std::numeric_limits<double>::epsilon();  // of TS's sums of times
  if (time == accepted_.time) return std::nextafter(time, std::numeric_limits<double>::infinity());
  const bool is_end = std::abs(time - step_.time) <= rounding * std::abs(step_.time);
  return step_.ends_at_event && is_end ? std::nextafter(step_.time, accepted_.time) : time;
}

void PetscIntegrator::begin_stage(double time, double dt, Vec q, Vec v, Vec a) {
  check(VecWAXPY(q0_.get(), -dt, v, q));
  check(VecWAXPY(v0_.get(), -dt, a, v));
  check(VecCopy(q, q_.get()));
  stage_ = {.time = within_step(time), .dt = dt, .q0 = q0_.get(), .v0 = v0_.get(), .step_start = accepted_.time};
  motion_.start_stage(stage_, q_.get());
  (void)equation_.enter(stage_, q_.get(), unknowns_.get());
}

void PetscIntegrator::evaluate_forces() {
  equation_.gradient(unknowns_.get(), r_.get());
  residual_ = norm(r_.get());
}

void PetscIntegrator::evaluate_first_order(double time, Vec y, Vec y_dot, Vec F) {
  split(y, q_part_.get(), v_part_.get());
  split(y_dot, rate_.get(), a_.get());
  begin_stage(time, time_step(), q_part_.get(), v_part_.get(), a_.get());
  evaluate_forces();
  if (!is_solving_) {
    // TS evaluates the slope at the step's start as -F at y' = 0, assuming F = y' - f(y).
    find_acceleration();
    check(VecScale(v_part_.get(), -1.0));
    check(VecScale(a_.get(), -1.0));
    join(v_part_.get(), a_.get(), F);
    return;
  }
  check(VecAXPY(rate_.get(), -1.0, v_part_.get()));
  {
    const ArrayView rows(rate_.get());
    const auto& prescribed = equation_.prescribed();
    for (std::size_t i = 0; i < rows.span().size(); ++i) {
      if (prescribed[i]) rows[static_cast<PetscInt>(i)] = 0.0;
    }
  }
  join(rate_.get(), r_.get(), F);
}

void PetscIntegrator::complete_guess(SNES snes, Vec x) {
  is_solving_ = true;
  is_stuck_ = false;
  if (is_handing_over()) {
    hand_over(x);
    return;
  }
  const double dt = time_step();
  ++statistics_.stages;
  if (is_second_order()) {
    // The unknown is q at the end of the step.
    PetscReal alpha_f = 0.0;
    check(TSAlpha2GetParams(ts_.get(), nullptr, &alpha_f, nullptr, nullptr));
    motion_.complete_step({stage_time_ + (1.0 - alpha_f) * dt, dt}, x, v_part_.get());
    return;
  }
  split(x, q_part_.get(), v_part_.get());
  motion_.complete_step({stage_time_, dt}, q_part_.get(), v_part_.get());
  join(q_part_.get(), v_part_.get(), x);
  // Sets v = q', which all further iterates keep.
  Handle<Vec> F;
  check(VecDuplicate(x, F.out()));
  check(SNESComputeFunction(snes, x, F.get()));
  check(VecAXPY(v_part_.get(), 1.0, rate_.get()));
  join(q_part_.get(), v_part_.get(), x);
}

void PetscIntegrator::search_line(SNESLineSearch search) {
  SNES snes = nullptr;
  Vec x = nullptr, f = nullptr, y = nullptr, trial = nullptr;
  check(SNESLineSearchGetSNES(search, &snes));
  check(SNESLineSearchGetVecs(search, &x, &f, &y, nullptr, &trial));
  check(SNESLineSearchSetReason(search, SNES_LINESEARCH_SUCCEEDED));
  // The direction in which the stage's configuration moves.
  PetscReal part = 1.0;
  if (is_second_order()) {
    check(TSAlpha2GetParams(ts_.get(), nullptr, &part, nullptr, nullptr));
    check(VecCopy(y, q_part_.get()));
  } else {
    split(y, q_part_.get(), v_part_.get());
  }
  check(VecScale(q_part_.get(), -part));
  const double bound = inversion_margin * equation_.max_step(unknowns_.get(), q_part_.get());
  if (bound < 1.0) ++statistics_.capped_steps;
  double lambda = std::min(1.0, bound);
  for (int i = 0; i < most_cuts; ++i, lambda *= 0.5) {
    check(VecWAXPY(trial, -lambda, y, x));
    check(SNESComputeFunction(snes, trial, f));
    const double after = norm(f);
    if (std::isfinite(after)) {
      check(VecCopy(trial, x));
      check(SNESLineSearchSetLambda(search, lambda));
      check(SNESLineSearchSetNorms(search, norm(x), after, lambda * norm(y)));
      return;
    }
    ++statistics_.backtracks;
  }
  is_stuck_ = true;
  check(SNESComputeFunction(snes, x, f));
  check(SNESLineSearchSetNorms(search, norm(x), norm(f), 0.0));
}

SNESConvergedReason PetscIntegrator::judge(PetscInt iteration, double f) {
  if (!std::isfinite(f)) return SNES_DIVERGED_FNORM_NAN;
  if (is_handing_over()) return SNES_CONVERGED_FNORM_ABS;
  if (is_stuck_) return SNES_DIVERGED_LINE_SEARCH;
  // Only the forces count: the row q' = v is exact.
  if (iteration == 0) scale_ = equation_.force_scale(unknowns_.get());
  if (iteration == 0) start_of_iteration_ = {residual_, norm(unknowns_.get())};
  const bool falls = iteration == 0 || residual_ < 0.5 * last_residual_;
  last_residual_ = residual_;
  const auto target = [&] { return std::max(options_.newton.relative * scale_, options_.newton.absolute); };
  if (iteration > 0 && residual_ <= target()) scale_ = std::min(scale_, equation_.force_scale(unknowns_.get()));
  if (residual_ <= target()) {
    if (residual_ > unbalanced_part * scale_) ++statistics_.unbalanced_stops;
    return SNES_CONVERGED_FNORM_RELATIVE;
  }
  const double floor = floor_factor * equation_.rounding_floor(unknowns_.get());
  if (iteration > 0 && residual_ <= (falls ? floor : 100.0 * floor) &&
      start_of_iteration_.allows_rounding(residual_, floor, norm(unknowns_.get()))) {
    ++statistics_.rounding_stops;
    return SNES_CONVERGED_FNORM_ABS;
  }
  return SNES_CONVERGED_ITERATING;
}

void PetscIntegrator::set_solution(Vec q, Vec v) {
  if (is_second_order()) {
    check(VecCopy(q, y_.get()));
    check(VecCopy(v, y_dot_.get()));
  } else {
    join(q, v, y_.get());
  }
}

void PetscIntegrator::roll_back() {
  // The history of a multistep method is internal to TS; only TSRollBack resets it to the start of this step.
  // TSRollBack is meant for steps that succeeded: its changes of time and solution after a failed one are undone by
  // `attempt`.
  if (!is_rolled_back_) check(TSRollBack(ts_.get()));
  is_rolled_back_ = true;
  is_tried_ = false;
}

StepAttempt PetscIntegrator::attempt(const Step& step) & {
  TS ts = ts_.get();
  step_ = step;
  if (is_tried_) roll_back();
  if (starts_) {
    check(TSRestartStep(ts));
    hand_over_points();
  }
  set_solution(accepted_.q.get(), accepted_.v.get());
  check(TSSetStepNumber(ts, num_accepted_));
  check(TSSetTime(ts, accepted_.time));
  check(TSSetTimeStep(ts, step.dt));
  num_stages_ = 0;
  if (starts_ && is_second_order()) find_start();
  PetscInt newton_before = 0, linear_before = 0;
  check(TSGetSNESIterations(ts, &newton_before));
  check(TSGetKSPIterations(ts, &linear_before));
  if (system_) linear_before = static_cast<PetscInt>(system_->linear_iterations());
  is_tried_ = true;
  guard_.rethrow(TSStep(ts));

  StepAttempt result;
  result.report = report_of(newton_before, linear_before);
  result.time = step.time;
  if (result.report.outcome != StageOutcome::converged) return result;
  is_rolled_back_ = false;
  if (is_second_order()) {
    check(VecCopy(y_.get(), end_.q.get()));
    check(VecCopy(y_dot_.get(), end_.v.get()));
    record_acceleration(step.dt);
  } else {
    split(y_.get(), end_.q.get(), end_.v.get());
  }
  end_.time = step.time;
  motion_.complete_step(step, end_.q.get(), end_.v.get());
  check(VecWAXPY(a_.get(), -1.0, q0_.get(), q_.get()));
  check(VecAXPBY(a_.get(), -1.0 / stage_.dt, 1.0 / (stage_.dt * stage_.dt), v0_.get()));
  result.q = end_.q.get();
  result.v = end_.v.get();
  result.last_stage = stage_;
  result.last_q = q_.get();
  result.last_a = a_.get();
  return result;
}

StageReport PetscIntegrator::report_of(PetscInt newton_before, PetscInt linear_before) {
  TS ts = ts_.get();
  SNES snes = nullptr;
  TSConvergedReason outcome = TS_CONVERGED_ITERATING;
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  PetscInt newton = 0, linear = 0;
  check(TSGetConvergedReason(ts, &outcome));
  check(TSGetSNES(ts, &snes));
  check(SNESGetConvergedReason(snes, &reason));
  check(TSGetSNESIterations(ts, &newton));
  check(TSGetKSPIterations(ts, &linear));
  if (system_) linear = static_cast<PetscInt>(system_->linear_iterations());
  StageReport report;
  report.newton_iterations = static_cast<int>(newton - newton_before);
  report.linear_iterations = static_cast<int>(linear - linear_before);
  statistics_.newton_iterations += report.newton_iterations;
  statistics_.linear_iterations += report.linear_iterations;
  if (outcome < 0) {
    report.outcome = StageOutcome::retry;
    report.reason = fmt::format("PETSc's {}: {}", TSConvergedReasons[outcome], SNESConvergedReasons[reason]);
  } else {
    report.reason = "converged";
  }
  return report;
}

void PetscIntegrator::accept([[maybe_unused]] const StepAttempt& attempt) {
  assert(is_tried_ && attempt.report.outcome == StageOutcome::converged && attempt.time == end_.time);
  if (is_bdf() && points_.empty()) {
    points_.push(middle_.view());
    points_.push(accepted_.view());
  }
  accepted_.assign(end_.view());
  if (is_bdf()) points_.push(accepted_.view());
  if (is_second_order()) {
    std::swap(acceleration_, end_a_);
    is_acceleration_recorded_ = true;
  }
  set_solution(accepted_.q.get(), accepted_.v.get());
  check(TSSetTime(ts_.get(), accepted_.time));
  ++num_accepted_;
  is_tried_ = false;
  starts_ = false;
  check(TSMonitor(ts_.get(), num_accepted_, accepted_.time, y_.get()));
}

}  // namespace pliant
