/// When the factor of an earlier Hessian is kept, and when it is renewed.
#pragma once

#include "solver/single_factorization.hpp"

namespace pliant {

/// A factorization is kept as long as it pays: conjugate gradients on the current Hessian, preconditioned by the factor
/// of an earlier one, need a few iterations, each a fraction of the cost of a factorization. A kept factor costs what
/// its solves take beyond those with a fresh one; when that adds up to a factorization, the next Hessian is
/// factorized. That is never more than twice what foresight would have cost (the ski rental problem: Karlin et al.
/// 1988, Competitive snoopy caching).
///
/// A value without PETSc objects; costs are iterations of the Krylov method, not seconds, so that every rank and every
/// run decides alike.
///
/// Invariants:
/// - A factor is wanted (`wants_factor`) before the first factorization, after one that failed, and always where the
///   linear solver does not iterate (`Solver::direct`).
/// - The excess of a kept factor starts at zero with each factorization, and never falls in between.
/// - A stage starts with no lack of memory on record; only a factorization that ran out of it puts one there.
class FactorPolicy {
 public:
  enum class Solver {
    iterative,  ///< a preconditioner made of another matrix will do
    direct      ///< the factor must be that of the matrix
  };
  /// Whose factor preconditions a linear system.
  enum class Factor { own, kept };

  explicit FactorPolicy(Solver solver) : solver_(solver) {}

  void begin_stage() { lacks_memory_ = false; }

  /// Whether the next Hessian is to be factorized.
  bool wants_factor() const { return is_wanted_; }
  /// The next Hessian is to be factorized, whatever the kept factor costs: it is far from the last, or the last was
  /// changed to be factorized at all.
  void renew() { is_wanted_ = true; }

  /// A factorization (or the set-up of another preconditioner) was done, with this outcome.
  void note_set_up(SetUp outcome);
  /// A factorization that was sound is no good: what stands beside the sparse matrix makes it singular.
  void note_failure();
  bool has_failed() const { return has_failed_; }
  bool lacks_memory() const { return lacks_memory_; }

  /// A linear system was solved to that many digits in that many iterations; `cost_of_set_up` in iterations.
  struct Solve {
    int iterations = 0;
    double digits = 0.0;
    double cost_of_set_up = 0.0;
  };
  void note_solve(const Solve& solve, Factor factor);
  /// Whether a solve took more iterations than a sound factor of its own matrix leaves.
  static bool is_poor(int iterations, Factor factor);

 private:
  Solver solver_;
  bool is_wanted_ = true;
  bool has_failed_ = false;
  bool lacks_memory_ = false;
  double fresh_rate_ = 0.0;  // iterations per digit with the last factor that was that of its matrix
  double excess_ = 0.0;      // iterations beyond those of fresh factors, since the last factorization
};

}  // namespace pliant
