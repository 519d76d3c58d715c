/// The integrators of PETSc (TS) on the same equation: a second opinion, and a baseline that many know.
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

/// Takes steps of a method of PETSc. TS is given F(t, q, v, a) = M a + dU/dq + dR/dv - f(t), which is the gradient of a
/// stage that starts from q0 = q - dt v, v0 = v - dt a; the length dt of the stage is then of no account. `alpha2`
/// solves the equation of second order as it is, the others that of first order in y = (q, v).
///
/// Where constraints tie displacements to one another, TS acts on those that are left: entries of slaves in its vectors
/// have no meaning, and follow their masters wherever a configuration is asked for.
///
/// The step is the one asked for: TS's own control of it is off. Nonlinear systems are solved by SNES with the exact
/// Jacobian and whole Newton steps, shortened only where a tetrahedron would invert or a number is not finite; they
/// converge as those of NewtonSolver do. Prescribed entries have their position, velocity and acceleration exactly, in
/// stages and at the ends of steps. PETSc's options (-ts_alpha_radius, -ts_bdf_order, -ts_arkimex_type, -snes_...)
/// reach TS.
///
/// At a spectral radius of 1, its default, `alpha2` is the implicit midpoint rule.
class PetscIntegrator {
 public:
  /// Starts from a copy of `initial`. `equation` outlives the integrator, its unknowns are displacements, those that
  /// linear constraints leave, and why_not() has nothing against its terms. `motion` changes nothing but prescribed
  /// entries and slaves. Throws
  /// PetscFailure where an option of PETSc names another integrator. Collective.
  PetscIntegrator(const PetscIntegratorOptions& options, StageEquation& equation, PrescribedMotion motion,
                  const StateView& initial);
  PetscIntegrator(const PetscIntegrator&) = delete;  // PETSc's objects point to it
  PetscIntegrator& operator=(const PetscIntegrator&) = delete;

  /// Tries the step from the last accepted state to `step.time`: converged or retry. An attempt that is not accepted
  /// leaves no trace. Of the attempt's last stage: the last equation solved; that of `alpha2` lies within the step.
  /// Collective.
  StepAttempt attempt(const Step& step) &;

  /// Makes the last attempt, which converged, the newest state. Collective.
  void accept(const StepAttempt& attempt);
  /// Forgets all but the newest state: TS starts anew from it, after an event at which velocities that are given or
  /// accelerations jump. The velocity becomes that after the event. Collective.
  void restart();
  /// What TS remembers of earlier states is given to it anew before the next step, as it is after restoring: the two go
  /// on alike to the last bit.
  void forget();
  /// The newest state, and of earlier ones what TS remembers. Collective.
  void keep(Archive& archive);

  /// The newest accepted state.
  const State& state() const { return accepted_; }

  /// What Newton's method has done; a stage is a nonlinear system. No times and no factorizations.
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
  /// The time at which a stage takes what is given as a function of time: what jumps at the step's start as it is
  /// after, and at its end as it is before.
  double within_step(double time) const;
  /// The stage of length dt in which the rates at q are v and a.
  void begin_stage(double time, double dt, Vec q, Vec v, Vec a);
  void evaluate_forces();
  void evaluate_first_order(double time, Vec y, Vec y_dot, Vec F);
  /// a_ = what M a = -forces gives, for methods that begin with the slope of the state they start from.
  void find_acceleration();
  /// TSALPHA2 finds its first acceleration from two half steps of backward Euler. It is handed two steps of constant
  /// acceleration instead, from which it finds the one it had, or that balances the forces if it had none.
  void find_start();
  bool is_finding_start() const { return is_second_order() && starts_ && num_stages_ <= 2; }
  /// Lets TSBDF take the steps between its points again, with their ends for solutions.
  void hand_over_points();
  /// TS is told what it would solve for: all residuals are zero.
  bool is_handing_over() const { return handed_ != 0 || is_finding_start(); }
  void complete_guess(SNES snes, Vec x);
  /// x = what TS is to find.
  void hand_over(Vec x);
  void search_line(SNESLineSearch search);
  SNESConvergedReason judge(PetscInt iteration, double norm);
  void roll_back();
  void set_solution(Vec q, Vec v);
  /// end_a_ at the end of a step of TSALPHA2.
  void record_acceleration(double dt);
  StageReport report_of(PetscInt newton_before, PetscInt linear_before);

  PetscIntegratorOptions options_;
  StageEquation& equation_;
  PrescribedMotion motion_;
  Handle<TS> ts_;
  Handle<Mat> K_;                          // of the second-order equation
  std::unique_ptr<ReducedSystem> system_;  // of the first-order one
  Handle<Vec> y_, y_dot_;                  // TS's solution: y alone, or q and v
  CallbackGuard guard_;
  SolverStatistics statistics_;

  Step step_;  // that is tried
  State accepted_;
  State end_;  // of the attempt
  PetscInt num_accepted_ = 0;
  bool starts_ = true;           // TS has no past in the next step, or is given it
  bool is_tried_ = false;        // TS has moved on from the accepted state
  bool is_rolled_back_ = false;  // TS knows that it starts from there again

  // What TS remembers of earlier steps.
  BdfPoints points_{0};               // those of TSBDF
  State middle_;                      // of its first step
  std::size_t handed_ = 0;            // the point that is being given to it; or 0
  Handle<Vec> acceleration_, end_a_;  // TSALPHA2's own, of the accepted state and at the attempt's end [m/s^2]
  bool is_acceleration_recorded_ = false;

  // The stage at hand.
  double stage_time_ = 0.0;  // as TS announces it [s]
  int num_stages_ = 0;       // announced in this attempt
  bool is_solving_ = false;  // a nonlinear system, not a slope
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
