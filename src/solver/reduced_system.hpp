/// Linear systems of a first-order equation in y = (q, v), reduced to systems in q.
#pragma once

#include "energy/stage_equation.hpp"
#include "petsc/handle.hpp"
#include "solver/linear.hpp"

namespace pliant {

/// A vector for y = (q, v): each rank's entries of q, then those of v. Collective.
Handle<Vec> make_state_vector(Vec q);
/// Copies the owned entries of y to q and v, and back. Not collective.
void split(Vec y, Vec q, Vec v);
void join(Vec q, Vec v, Vec y);

/// The Jacobian of F(y, y') = (q' - v, r(q, v, v')) at the shift sigma = dy'/dy,
///
///     J = [ sigma I        -I     ]      M = dr/dv',  C = dr/dv,  K = dr/dq,
///         [    K     sigma M + C  ]
///
/// through the Hessian of a stage of length 1/sigma, H = K + sigma C + sigma^2 M. If the residual of the first row is
/// zero, J (dq, dv) = (0, r) means H dq = r, dv = sigma dq. That row is linear, so Newton's method keeps it zero from a
/// guess with v = q' on. Only such systems are solved here, and J is applied only to their solutions.
class ReducedSystem {
 public:
  ReducedSystem(const StageEquation& equation, LinearKind linear);
  ReducedSystem(const ReducedSystem&) = delete;  // PETSc's objects point to it
  ReducedSystem& operator=(const ReducedSystem&) = delete;

  /// Makes `ksp` solve systems with matrix().
  void configure(KSP ksp);

  /// J, as an operator alone.
  Mat matrix() const { return J_.get(); }
  /// H, to be assembled by the caller for the shift that was set.
  Mat hessian() const { return H_.get(); }
  /// Sets sigma [1/s].
  void set_shift(double sigma) { sigma_ = sigma; }

  /// Iterations for the systems in q, since the object was made.
  long long linear_iterations() const { return linear_iterations_; }

 private:
  static PetscErrorCode multiply_callback(Mat J, Vec x, Vec y);
  static PetscErrorCode solve_callback(PC pc, Vec r, Vec x);
  void multiply(Vec x, Vec y);
  bool solve(Vec r, Vec x);

  double sigma_ = 0.0;
  Handle<Mat> H_, J_;
  Handle<KSP> ksp_;
  Handle<Vec> a_, b_, c_;
  long long linear_iterations_ = 0;
};

}  // namespace pliant
