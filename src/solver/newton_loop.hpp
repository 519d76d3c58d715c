/// Newton's iteration from a guess, with PETSc's SNES.
#pragma once

#include "petsc/callback.hpp"
#include "petsc/handle.hpp"
#include "solver/convergence.hpp"
#include "solver/forcing.hpp"
#include "solver/iteration.hpp"
#include "solver/iteration_log.hpp"
#include "solver/line_search.hpp"
#include "solver/linear.hpp"
#include "solver/linear_system.hpp"
#include "solver/newton_line.hpp"

namespace pliant {

/// SNES runs the loop, which users monitor and configure through PETSc's options; its parts are Pliant's. Their order:
///
///     r = gradient(q)
///     while judge(q, r) is `iterating`:             Convergence
///       K = Hessian(q), with a factor                linearize: LinearSystem, FactorPolicy
///       d = -K^-1 r, by a Krylov method              SNES's KSP, with the tolerance from Forcing
///       until a step length along d is accepted:     search: LineSearch along a NewtonLine
///         K, d = the next in the fallback sequence   Escalation; at its end the run fails
///       q, r = the new iterate and its residual
///
/// Invariants:
/// - `value_` is the potential at the iterate if it is minimised: the start of a run sets it (`begin`, `resume` or
///   `use_guess`), and each step updates it.
/// - Every decision depends on numbers that are the same on all ranks.
/// - Nothing is thrown through PETSc: `guard_` carries an exception of a callback to `run`.
class NewtonLoop final : public Iteration {
 public:
  /// PETSc options -snes_..., -ksp_..., -pc_... override. The references outlive the object. Collective.
  NewtonLoop(Objective& objective, const NewtonOptions& options, LinearKind linear, SolverStatistics& statistics);
  NewtonLoop(const NewtonLoop&) = delete;  // PETSc's objects point to it
  NewtonLoop& operator=(const NewtonLoop&) = delete;

  LinearSystem& system() { return system_; }
  KSP linear_solver() const;
  Convergence& convergence() { return convergence_; }
  IterationLog& log() { return log_; }

  void begin_stage();
  /// Makes the guess of the stage, with its measure, the start of the next run. Collective.
  void use_guess(Vec q, double measure);
  /// Prepares a run from a solution for other coefficients of the equation. Collective.
  void resume(Vec q);
  /// Forgets what was learned from earlier stages.
  void forget();
  /// The last direction y of the stage, which leads from an iterate q to q - y; nullptr if there was none.
  Vec last_direction() const;

  void begin(Vec q, Aim aim) override;
  void begin_again(Vec q) override;
  StageReport run(Vec q) override;
  StageReport run(Vec q, int max_iterations) override;
  bool is_converging() const override;
  bool is_stable(Vec q) override { return system_.is_stable(q); }
  void renew_factor() override { system_.factor().renew(); }
  double stiffness(Vec q) override;
  void accept(double residual) override { convergence_.accept(residual); }

 private:
  static PetscErrorCode residual_callback(SNES, Vec q, Vec r, void* self);
  static PetscErrorCode hessian_callback(SNES, Vec q, Mat K, Mat P, void* self);
  static PetscErrorCode line_search_callback(SNESLineSearch search, void* self);
  static PetscErrorCode convergence_callback(SNES, PetscInt it, PetscReal, PetscReal, PetscReal f,
                                             SNESConvergedReason* reason, void* self);

  /// Limits the iterations of the next runs.
  void limit_iterations(int number);
  /// Makes a SNES with its KSP, configured for K and by PETSc's options.
  Handle<SNES> make_snes(Mat K, const NewtonOptions& options, LinearKind linear);

  void linearize(Vec q);
  /// Whether the Hessian of the iterate before is near enough to that of this one for the step to the solution.
  bool keeps_hessian() const;
  /// Whether the Hessian is likely to need projected barriers, as in the last iteration of this run.
  bool goes_on_projecting() const;
  /// Sets the tolerance of the next linear system.
  void set_tolerance();
  void search(SNESLineSearch search);
  /// Searches along -y and takes the step; returns false if no step length helps.
  bool go_along(Vec q, Vec r, Vec y, SNESLineSearch search);
  SNESConvergedReason judge(int iteration, double residual);
  void note_iteration(int iteration, double residual);
  StageReport report_of(SNESConvergedReason reason) const;

  Objective& objective_;
  StageEquation& equation_;
  NewtonOptions options_;
  SolverStatistics& statistics_;
  CallbackGuard guard_;
  Handle<Vec> r_;
  Handle<Mat> K_;  // until the linear system takes it over
  Handle<SNES> snes_;
  LinearSystem system_;
  NewtonLine line_;
  LineSearch line_search_;
  Convergence convergence_;
  Forcing forcing_;
  IterationLog log_;
  double value_ = 0.0;            // potential at the iterate, if it is minimised
  int limit_ = 0;                 // most iterations of a run, those that end at a wall not counted
  int num_at_wall_ = 0;           // iterations of this run that did
  int num_projecting_ = 0;        // iterations of this run, the last ones, with projected barriers from the start
  bool has_old_hessian_ = false;  // the linear system has the Hessian of the iterate before
  double last_length_ = 0.0;      // length of the last accepted step, relative to the full Newton step
  bool is_at_rounding_ = false;   // the last line search of this run ended there
  bool has_direction_ = false;    // there was a direction in this stage
  bool adapts_tolerance_ = true;  // false if the user gives a tolerance
};

}  // namespace pliant
