/// The fallback sequence of Newton's method for linear systems that give no usable direction: a state machine.
#pragma once

namespace pliant {

/// The fallback sequence of one iteration: which Hessian the linear system has, and whose factor preconditions it.
///
///     kept_factor -> fresh_factor -> projected -> projected_and_shifted -> smaller_step
///                         |            ^
///                         v            |
///                    made_definite ----+
///
/// A value type without a matrix: the owner of the linear system reports what was done to it (`begin`,
/// `factorized`, `shifted`, `projected`) and asks what to do next (`escalate`). Every rank holds the same state, since
/// all calls depend on reduced numbers.
///
/// Invariants:
/// - `escalate` never goes back: repeated calls reach `smaller_step` after at most four, and stay there until `begin`.
/// - Only `begin` leads to `kept_factor`, the only state in which the factor belongs to another matrix.
/// - `smaller_step` is the only state without a factor to solve with.
class Escalation {
 public:
  enum class State {
    kept_factor,    ///< the exact Hessian, preconditioned by the factor of an earlier one (or by none yet)
    fresh_factor,   ///< the exact Hessian and its own factor
    made_definite,  ///< without negative eigenvalues: with projected barriers, or the least shift of its diagonal
    projected,      ///< positive semidefinite, cell by cell
    projected_and_shifted,  ///< projected, with its diagonal shifted as well, since it may be singular
    smaller_step            ///< nothing left to try: repeat the step with a smaller length
  };
  /// What may be done to the Hessian.
  enum class Permission {
    anything,
    exact_hessian,  ///< any equilibrium is sought, and only the exact Hessian leads to those that are not minima
    nothing         ///< there is not enough memory, and another matrix would need as much
  };

  State state() const { return state_; }
  bool has_kept_factor() const { return state_ == State::kept_factor; }
  bool is_projected() const { return state_ == State::projected || state_ == State::projected_and_shifted; }
  bool is_shifted() const { return state_ == State::made_definite || state_ == State::projected_and_shifted; }

  /// Reports that the exact Hessian of an iterate was assembled; it has no factor of its own yet.
  void begin() { state_ = State::kept_factor; }
  /// Reports that the matrix was factorized unchanged.
  void factorized();
  /// Reports that the Hessian was assembled with projected barriers, else exact; a factorization follows.
  void barriers_projected() { state_ = State::made_definite; }
  /// Reports that the diagonal of the matrix was shifted; a factorization follows.
  void shifted();
  /// Reports that the projected Hessian was assembled; a factorization follows.
  void projected() { state_ = State::projected; }
  /// Goes to the next state, which the owner of the matrix must then establish. From `kept_factor` the factorization
  /// may find the Hessian indefinite, and the owner may report `shifted` or `projected` without being asked.
  State escalate(Permission permission);

 private:
  State state_ = State::kept_factor;
};

}  // namespace pliant
