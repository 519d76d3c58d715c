/// The policy that decides when the factor of an earlier Hessian is kept, and when it is renewed.
#pragma once

#include "solver/single_factorization.hpp"

namespace pliant {

/// A factorization is kept as long as it pays. Conjugate gradients on the current Hessian, preconditioned by an earlier
/// factor, need a few iterations, each at a fraction of the cost of a factorization. The cost of a kept factor is the
/// iterations that its solves need beyond those with a fresh one. When their sum reaches the cost of a factorization,
/// the next Hessian is factorized. The total is at most twice the cost with foresight (the ski rental problem: Karlin
/// et al. 1988, Competitive snoopy caching).
///
/// A value type without PETSc objects. Costs are iterations of the Krylov method, not seconds: every rank and every run
/// takes the same decisions.
///
/// Invariants:
/// - A factor is wanted (`wants_factor`) before the first factorization, after one that failed, and always where the
///   linear solver does not iterate (`Solver::direct`).
/// - The excess of a kept factor starts at zero with each factorization, and never falls in between.
/// - `lacks_memory` is false at the start of a stage; only a factorization that ran out of memory sets it.
class FactorPolicy {
 public:
  enum class Solver {
    iterative,  ///< the preconditioner may be made from another matrix
    direct      ///< the factor must belong to the matrix itself
  };
  /// Which factor preconditions a linear system: its own, or a kept one.
  enum class Factor { own, kept };
  /// What is factorized of the matrix; nothing if multigrid takes the place of a factorization while that pays.
  enum class Factored { whole, symmetric_part, nothing };

  explicit FactorPolicy(Solver solver) : solver_(solver) {}

  void begin_stage() { lacks_memory_ = false; }

  /// Whether the next Hessian is to be factorized.
  bool wants_factor() const { return is_wanted_; }
  /// Makes the next Hessian be factorized, whatever the kept factor costs: it differs much from the last one, or the
  /// last one had to be changed before it could be factorized.
  void renew() { is_wanted_ = true; }

  /// Records the outcome of a factorization, or of the set-up of another preconditioner.
  void note_set_up(SetUp outcome);
  /// Records that a sound factorization cannot be used: the rank-one terms added to the sparse matrix make it singular.
  void note_failure();
  bool has_failed() const { return has_failed_; }
  bool lacks_memory() const { return lacks_memory_; }

  /// A solved linear system: the digits reached, the iterations needed, and the cost of a set-up in iterations.
  struct Solve {
    int iterations = 0;
    double digits = 0.0;
    double cost_of_set_up = 0.0;
  };
  void note_solve(const Solve& solve, Factor factor);
  /// Whether a solve took more iterations than it would with a sound factor of its own matrix, or than pays: for the
  /// factor of its symmetric part, which takes half the work, and for multigrid.
  static bool is_poor(const Solve& solve, Factor factor, Factored factored);

 private:
  Solver solver_;
  bool is_wanted_ = true;
  bool has_failed_ = false;
  bool lacks_memory_ = false;
  double fresh_rate_ = 0.0;  // iterations per digit in the last solve with a matrix's own factor
  double excess_ = 0.0;      // iterations beyond those with a fresh factor, since the last factorization
};

}  // namespace pliant
