/// What Newton's method falls back on when a linear system gives no usable direction: an explicit state machine.
#pragma once

namespace pliant {

/// The fallback sequence of one iteration: which Hessian the linear system has, and whose factor preconditions it.
///
///     kept_factor -> fresh_factor -> projected -> projected_and_shifted -> smaller_step
///                         |            ^
///                         v            |
///                    made_definite ----+
///
/// A value that knows no matrix: whoever owns the linear system reports what was done to it (`begin`, `factorized`,
/// `shifted`, `projected`) and asks what to do next (`escalate`). Every rank holds the same state, since all calls
/// rest on reduced numbers.
///
/// Invariants:
/// - `escalate` never leads back: a search that asks again and again arrives at `smaller_step` after four calls at
///   most, and stays there until `begin`.
/// - Only `begin` leads to `kept_factor`, and only there is the factor that of another matrix.
/// - `smaller_step` is the only state in which there is nothing to solve with.
class Escalation {
 public:
  enum class State {
    kept_factor,            ///< the exact Hessian, preconditioned by the factor of an earlier one (or by none yet)
    fresh_factor,           ///< the exact Hessian and its own factor
    made_definite,          ///< the least shift of its diagonal at which it has no negative eigenvalue
    projected,              ///< positive semidefinite, cell by cell
    projected_and_shifted,  ///< its diagonal shifted as well, for it may be singular
    smaller_step            ///< nothing left: the step is to be tried with a smaller length
  };
  /// What may be done to the Hessian.
  enum class Permission {
    anything,
    exact_hessian,  ///< any equilibrium will do, and only the exact Hessian leads to those that are not minima
    nothing         ///< another matrix would take as much memory, which does not suffice
  };

  State state() const { return state_; }
  bool has_kept_factor() const { return state_ == State::kept_factor; }
  bool is_projected() const { return state_ == State::projected || state_ == State::projected_and_shifted; }
  bool is_shifted() const { return state_ == State::made_definite || state_ == State::projected_and_shifted; }

  /// The exact Hessian of an iterate was assembled; it has no factor of its own yet.
  void begin() { state_ = State::kept_factor; }
  /// The matrix was factorized as it is.
  void factorized();
  /// The diagonal of the matrix was shifted, with a factorization to follow.
  void shifted();
  /// The projected Hessian was assembled, with a factorization to follow.
  void projected() { state_ = State::projected; }
  /// Goes to the next state, which the owner of the matrix must then bring about. From `kept_factor` the factorization
  /// may find the Hessian indefinite and report `shifted` or `projected` on its own.
  State escalate(Permission permission);

 private:
  State state_ = State::kept_factor;
};

}  // namespace pliant
