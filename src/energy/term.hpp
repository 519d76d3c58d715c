/// The contract of everything that contributes to a stage's equation.
#pragma once

#include "fem/block_matrix.hpp"

#include <limits>
#include <span>
#include <string_view>

namespace pliant {

/// A stage as the terms see it: StagePoint with the arrays of this rank, owned nodes first, then ghosts, xyz per node.
struct LocalStage {
  double time = 0.0;           ///< t_i [s]
  double dt = 0.0;             ///< dt_i [s]
  double load_factor = 1.0;    ///< multiplies loads
  std::span<const double> q0;  ///< stage-start displacement [m]
  std::span<const double> v0;  ///< stage-start velocity [m/s]
};

/// Whether the Hessian is taken as it is or made positive semidefinite cell by cell.
enum class Projection { none, positive_semidefinite };

/// What a term says of itself; the solver picks the line search from what all terms say.
struct TermDeclaration {
  bool is_potential = true;              ///< the gradient is that of `value`
  bool has_frozen_coefficients = false;  ///< coefficients are frozen at the stage's start (first order in time)
};

/// One contribution to the incremental potential of a stage (docs: dynamics, Phi_i). The arrays span all local nodes; a
/// term adds to the rows of owned nodes completely (what it leaves in ghost rows is ignored), and counts energies of
/// owned cells and nodes only, so that a sum over ranks is the total. No method is collective.
class EnergyTerm {
 public:
  virtual ~EnergyTerm() = default;

  virtual std::string_view name() const = 0;
  virtual TermDeclaration declaration() const = 0;

  /// Phi(q) - Phi(q0) of this rank's part [J]: a difference, summed cell by cell with compensation, so that small
  /// changes survive beside large totals. +inf where a barrier is crossed.
  virtual double value(const LocalStage& stage, std::span<const double> q) const = 0;

  /// r += dPhi/dq [N]. NaN where a barrier is crossed.
  virtual void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const = 0;

  /// K += d2Phi/dq2 [N/m], rows of owned nodes.
  virtual void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                           Projection projection) const = 0;

  /// The largest alpha for which q + alpha d stays clear of the term's barrier; +inf if it has none.
  virtual double max_step(std::span<const double> /*q*/, std::span<const double> /*d*/) const {
    return std::numeric_limits<double>::infinity();
  }
};

}  // namespace pliant
