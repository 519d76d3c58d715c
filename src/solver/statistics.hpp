/// Statistics that a stage solver reports.
#pragma once

namespace pliant {

/// Fraction of the acting forces; a solve that leaves a larger residual has hardly begun.
constexpr double unbalanced_part = 0.1;
/// A residual at the limit of double precision, as a fraction of the forces, above which results may be affected.
constexpr double doubtful_rounding = 1e-6;

/// The work of a solver since it was made.
struct SolverStatistics {
  long long stages = 0;
  long long minimisations = 0;    ///< stages solved on the incremental potential
  long long residual_solves = 0;  ///< stages solved on the residual, because a term has no potential
  long long newton_iterations = 0;
  long long linear_iterations = 0;
  long long factorizations = 0;         ///< or set-ups of another preconditioner
  long long backtracks = 0;             ///< step lengths rejected by the line search
  long long capped_steps = 0;           ///< steps shortened because a tetrahedron would have inverted
  long long projections = 0;            ///< Hessians made positive semidefinite cell by cell
  long long regularizations = 0;        ///< projected Hessians that needed a shift of their diagonal too
  long long rounding_stops = 0;         ///< stages whose residual ended at its rounding floor, above the tolerance
  long long unstable_stages = 0;        ///< equilibria at which the Hessian has negative eigenvalues
  double worst_rounding = 0.0;          ///< the largest residual of `rounding_stops`, over the forces or M v / dt
  long long unsettled_stages = 0;       ///< taken although normal forces jump between two solves (CoefficientSearch)
  double worst_unsettled = 0.0;         ///< the largest part of the drag that one of them lacks
  long long unbalanced_stops = 0;       ///< stages that `absolute` ended while a tenth of the forces was unbalanced
  bool uses_multigrid_instead = false;  ///< of the factorization, for which there was too little memory
  double assembly_seconds = 0.0;        ///< residuals, energies, Hessians
  double factorization_seconds = 0.0;
  double solve_seconds = 0.0;
};

/// Progress of the solve of a stage.
struct StageProgress {
  double seconds = 0.0;  ///< since its start
  int iteration = 0;     ///< of Newton's method
  double residual = 0.0, target = 0.0;
  int linear_iterations = 0;  ///< of the last linear system
};

}  // namespace pliant
