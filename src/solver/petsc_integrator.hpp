/// PETSc's integrators (TS) on the same equation: an independent check, and a well-known baseline.
#pragma once

#include "energy/stage_equation.hpp"
#include "petsc/callback.hpp"
#include "petsc/handle.hpp"
#include "solver/bdf_points.hpp"
#include "solver/linear.hpp"
#include "solver/newton.hpp"
#include "solver/petsc_method.hpp"
#include "solver/reduced_system.hpp"
#include "time/state.hpp"
#include "time/stepper.hpp"

#include <memory>

namespace pliant {

struct PetscIntegratorOptions {
  PetscMethod method;
  NewtonOptions newton;
  LinearKind linear = LinearKind::cholesky;
};

/// Takes steps with one of PETSc's methods. TS receives F(t, q, v, a) = M a + dU/dq + dR/dv - f(t), the gradient of a
/// stage that starts from q0 = q - dt v, v0 = v - dt a, whose length dt then has no influence. `alpha2` solves the
/// second-order equation directly, the other methods the first-order equation in y = (q, v).
///
/// If constraints tie displacements to one another (multi-point constraints), TS acts on the remaining ones: the
/// entries of slaves in its vectors have no meaning, and follow their masters whenever a configuration is needed.
///
/// TS takes exactly the requested step: its own step control is off. SNES solves the nonlinear systems with the exact
/// Jacobian and whole Newton steps, which are shortened only if a tetrahedron would invert or a number is not finite;
/// the convergence test is that of NewtonSolver. Prescribed entries have their exact position, velocity and
/// acceleration in stages and at the ends of steps. PETSc's options (-ts_alpha_radius, -ts_bdf_order, -ts_arkimex_type,
/// -snes_...) apply.
///
/// At a spectral radius of 1, its default, `alpha2` is the implicit midpoint rule.
class PetscIntegrator {
 public:
  /// Starts from a copy of `initial`. `equation` outlives the integrator; its unknowns are the displacements that
  /// linear constraints leave free, and why_not() allows its terms. `motion` changes only prescribed entries and
  /// slaves. Throws PetscFailure if a PETSc option names another integrator. Collective.
  PetscIntegrator(const PetscIntegratorOptions& options, StageEquation& equation, PrescribedMotion motion,
                  const StateView& initial);
  PetscIntegrator(const PetscIntegrator&) = delete;  // PETSc's objects point to it
  PetscIntegrator& operator=(const PetscIntegrator&) = delete;

  /// Tries the step from the last accepted state to `step.time`; the outcome is converged or retry. An attempt that is
  /// not accepted leaves no trace. The attempt's last stage is the last equation solved; for `alpha2` it lies within
  /// the step. Collective.
  StepAttempt attempt(const Step& step) &;

  /// Makes the last attempt, which converged, the newest state. Collective.
  void accept(const StepAttempt& attempt);
  /// Forgets all but the newest state: TS starts anew from it, after an event at which prescribed velocities or
  /// accelerations jump. The velocity becomes that after the event. Collective.
  void restart();
  /// Makes TS receive its history anew before the next step, as after restoring: both continue identically to the last
  /// bit.
  void forget();
  /// Keeps the newest state, and TS's history of earlier ones. Collective.
  void keep(Archive& archive);

  /// The newest accepted state.
  const State& state() const { return accepted_; }

  /// Statistics of Newton's method; a stage is one nonlinear system. Contains no times and no factorizations.
  const SolverStatistics& statistics() const { return statistics_; }

 private:
  static PetscErrorCode stage_callback(TS ts, PetscReal time);
  static PetscErrorCode solved_callback(TS ts, PetscReal time, PetscInt, Vec* y);
  static PetscErrorCode second_order_residual(TS, PetscReal t, Vec q, Vec v, Vec a, Vec F, void* self);
  static PetscErrorCode second_order_jacobian(TS, PetscReal t, Vec q, Vec v, Vec a, PetscReal shift_v,
                                              PetscReal shift_a, Mat J, Mat P, void* self);
  static PetscErrorCode first_order_residual(TS, PetscReal t, Vec y, Vec y_dot, Vec F, void* self);
  static PetscErrorCode first_order_jacobian(TS, PetscReal t, Vec y, Vec y_dot, PetscReal shift, Mat J, Mat P,
                                             void* self);
  static PetscErrorCode guess_callback(SNES, Vec x, void* self);
  static PetscErrorCode line_search_callback(SNESLineSearch search, void* self);
  static PetscErrorCode convergence_callback(SNES, PetscInt it, PetscReal, PetscReal, PetscReal f,
                                             SNESConvergedReason* reason, void* self);

  bool is_bdf() const { return options_.method.kind == PetscMethod::Kind::bdf; }
  bool is_second_order() const { return options_.method.kind == PetscMethod::Kind::alpha2; }
  void configure_time_stepping();
  void configure_newton();
  double time_step() const;
  /// The time at which a stage evaluates functions of time: just after jumps at the step's start, and just before jumps
  /// at its end.
  double within_step(double time) const;
  /// The stage of length dt in which the rates at q are v and a.
  void begin_stage(double time, double dt, Vec q, Vec v, Vec a);
  void evaluate_forces();
  void evaluate_first_order(double time, Vec y, Vec y_dot, Vec F);
  /// a_ = the solution of M a = -forces, for methods that begin with the slope at their initial state.
  void find_acceleration();
  /// TSALPHA2 computes its first acceleration from two half steps of backward Euler. It receives two steps of constant
  /// acceleration instead, from which it recovers its previous acceleration, or the one that balances the forces if
  /// there was none.
  void find_start();
  bool is_finding_start() const { return is_second_order() && starts_ && num_stages_ <= 2; }
  /// Makes TSBDF repeat the steps between its recorded points, with these as the solutions.
  void hand_over_points();
  /// Whether TS receives its solutions instead of solving for them; all residuals are then zero.
  bool is_handing_over() const { return handed_ != 0 || is_finding_start(); }
  void complete_guess(SNES snes, Vec x);
  /// x = the solution that TS is to find.
  void hand_over(Vec x);
  void search_line(SNESLineSearch search);
  SNESConvergedReason judge(PetscInt iteration, double norm);
  void roll_back();
  void set_solution(Vec q, Vec v);
  /// Computes end_a_ at the end of a step of TSALPHA2.
  void record_acceleration(double dt);
  StageReport report_of(PetscInt newton_before, PetscInt linear_before);

  PetscIntegratorOptions options_;
  StageEquation& equation_;
  PrescribedMotion motion_;
  Handle<TS> ts_;
  Handle<Mat> K_;                          // of the second-order equation
  std::unique_ptr<ReducedSystem> system_;  // of the first-order equation
  Handle<Vec> y_, y_dot_;                  // TS's solution: y alone, or q and v
  CallbackGuard guard_;
  SolverStatistics statistics_;

  Step step_;  // the current attempt
  State accepted_;
  State end_;  // of the attempt
  PetscInt num_accepted_ = 0;
  bool starts_ = true;           // TS has no history in the next step, or receives it
  bool is_tried_ = false;        // TS has moved on from the accepted state
  bool is_rolled_back_ = false;  // TS knows that it starts from there again

  // TS's history of earlier steps.
  BdfPoints points_{0};               // of TSBDF
  State middle_;                      // middle of TSBDF's first step
  std::size_t handed_ = 0;            // index of the point that TSBDF is receiving; 0: none
  Handle<Vec> acceleration_, end_a_;  // of TSALPHA2, in the accepted state and at the attempt's end [m/s^2]
  bool is_acceleration_recorded_ = false;

  // The stage at hand.
  double stage_time_ = 0.0;  // as TS announces it [s]
  int num_stages_ = 0;       // announced in this attempt
  bool is_solving_ = false;  // TS solves a nonlinear system; otherwise it evaluates a slope
  StagePoint stage_;
  Handle<Vec> q0_, v0_, q_, unknowns_, r_;
  Handle<Vec> q_part_, v_part_, rate_, a_, start_v_;
  IterationStart start_of_iteration_;
  double residual_ = 0.0, last_residual_ = 0.0, scale_ = 0.0;  // [N]
  bool is_stuck_ = false;

  Handle<Mat> mass_;
  Handle<KSP> mass_solver_;
};

}  // namespace pliant
