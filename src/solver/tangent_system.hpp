/// The linear system of the tangent of a stage: how its solution moves with what it depends on.
#pragma once

#include "petsc/handle.hpp"
#include "solver/linear_system.hpp"
#include "solver/objective.hpp"

#include <span>

namespace pliant {

/// K y = r with the exact Hessian K at the solution of a stage, for several right-hand sides r: what a change of the
/// residual moves the solution by. The kept factor preconditions it. Collective.
class TangentSystem {
 public:
  /// The linear solver `ksp` is that of `system`. The references outlive the object.
  TangentSystem(Objective& objective, LinearSystem& system, KSP ksp)
      : objective_(objective), system_(system), ksp_(ksp) {}

  /// Assembles K at q, the unknowns that solve the present stage. Returns false if it has no factor. On the way to the
  /// solution, K is that of Newton's method at q, reached from `from` (StageEquation::extrapolate_from).
  bool begin(Vec q, Vec from = nullptr);
  /// Solves to ten digits, or until the residual has fallen to this part of r; returns false if the linear solver
  /// fails.
  bool solve(Vec r, Vec y, double part = 1e-10);
  /// The same for several right-hand sides, from the residuals r at guesses (nullptr: 0), until each has fallen to this
  /// part of what it is at 0. y is to be added to the guesses.
  bool solve(std::span<const Vec> r, std::span<const Vec> guesses, std::span<const Vec> y, double part);
  /// y = K x.
  void multiply(Vec x, Vec y) const { check(MatMult(system_.matrix(), x, y)); }
  /// To be called after the last solve: the next stage may begin.
  void end();

 private:
  bool has_solved() const;
  bool solve_from(Vec guess, Vec r, Vec y, double part);

  Objective& objective_;
  LinearSystem& system_;
  KSP ksp_;
  Vec q_ = nullptr;
};

}  // namespace pliant
