/// The contract of everything that contributes to a stage's equation, its residual r (out-of-balance force) and Hessian
/// K (tangent stiffness).
#pragma once

#include "base/vector3.hpp"
#include "energy/coupling.hpp"
#include "fem/block_matrix.hpp"

#include <array>
#include <limits>
#include <span>
#include <string_view>

namespace pliant {

/// A number S summed over all ranks (energy/function_of_sum.hpp).
struct SumOverRanks {
  double start = 0.0;   ///< S(q0)
  double change = 0.0;  ///< S(q) - S(q0)
  double total() const { return start + change; }
};

/// A stage as the terms see it: StagePoint with the arrays of this rank, owned nodes first, then ghosts, xyz per node.
struct LocalStage {
  double time = 0.0;                         ///< t_i [s]
  double dt = 0.0;                           ///< dt_i [s]
  double load_factor = 1.0;                  ///< multiplies loads
  std::span<const double> q0 = {};           ///< stage-start displacement [m]
  std::span<const double> v0 = {};           ///< stage-start velocity [m/s]
  std::span<const double> z0 = {};           ///< the term's own internal variables at the stage's start
  SumOverRanks sum = {};                     ///< of a FunctionOfSum, at the q of the call
  const NearPatches* near = nullptr;         ///< of a PairCoupling, at the q of the call (and along its direction)
  const NearPatches* near_frozen = nullptr;  ///< likewise, at PairCoupling::frozen_place
  /// Displacement at which coefficients of terms that refreeze are frozen, at t_i; empty: they follow the q of the
  /// call.
  std::span<const double> frozen = {};
  /// Displacement from which the q of the call was reached (StageEquation::extrapolate_from); empty if there is none.
  std::span<const double> previous = {};
  /// Whether coefficients that are otherwise frozen at the step's start refreeze too, because they exceed their bound
  /// (StageEquation::refreeze).
  bool exceeds_bound = false;
  /// Displacement from which the step starts, at `step_start` [m]; empty if there is none (StagePoint::accepted).
  std::span<const double> accepted = {};
  double step_start = 0.0;  ///< t_n [s]
  /// The term's own internal variables there; empty: none before (StagePoint::accepted_z).
  std::span<const double> accepted_z = {};

  /// The displacement relative to which `EnergyTerm::value` is computed: close to q, and never beyond a barrier, as q0
  /// may be when a method extrapolates it.
  std::span<const double> reference() const { return accepted.empty() ? q0 : accepted; }

  /// Whether coefficients are frozen at the step's start: those that do not refreeze, within their bound.
  bool is_frozen_at_start(bool refreezes) const { return !refreezes && !exceeds_bound; }
  /// The displacement at which they are frozen in a call with q.
  std::span<const double> frozen_at(bool refreezes, std::span<const double> q) const {
    // The start of a stage may be an extrapolation, beyond a barrier: the last accepted state is not.
    if (is_frozen_at_start(refreezes)) return reference();
    return frozen.empty() ? q : frozen;
  }
};

/// What an energy may depend on besides the configuration.
struct Instant {
  double time = 0.0;                  ///< [s]
  double load_factor = 1.0;           ///< LocalStage::load_factor
  const NearPatches* near = nullptr;  ///< LocalStage::near
};
inline Instant instant_of(const LocalStage& stage) {
  return {stage.time, stage.load_factor};
}

/// Whether the Hessian is exact or projected (made positive semidefinite cell by cell).
enum class Projection {
  none,
  walls,                 ///< that of terms with TermDeclaration::is_wall alone; asked only of their sum
  positive_semidefinite  ///< that of all terms
};

/// The account of the ledger to which the power of a term's forces belongs.
enum class Account {
  kinetic,         ///< inertia: changes the kinetic energy
  stored,          ///< elasticity: changes `EnergyTerm::energy`; `dissipation` is lost
  load_potential,  ///< done by loads that have an energy of their own, `EnergyTerm::energy`
  load             ///< done by other loads
};

/// The kind of matrix a Hessian is. That of a saddle point is symmetric with negative eigenvalues of its own
/// (indefinite); that of a soft body with a few rigid parts is symmetric but for their rows and columns (nearly
/// symmetric). `add_hessian` of a term adds a symmetric one, one that is symmetric but for rows and columns of rigid
/// parts, or an unsymmetric one.
enum class Symmetry { symmetric, unsymmetric, indefinite, nearly_symmetric };
constexpr bool is_symmetric(Symmetry symmetry) {
  return symmetry == Symmetry::symmetric || symmetry == Symmetry::indefinite;
}

/// Properties of a term; the solver chooses line search and linear solver from those of all terms.
struct TermDeclaration {
  bool is_potential = true;              ///< the gradient is that of `value`
  bool has_frozen_coefficients = false;  ///< coefficients are frozen at the step's start (first order in time)
  bool refreezes = false;                ///< coefficients are frozen at LocalStage::frozen: StageEquation::refreeze
  Symmetry symmetry = Symmetry::symmetric;
  Account account = Account::stored;
  bool depends_on_time = false;      ///< `energy_at` changes with time at a fixed configuration: `supply`
  bool has_moving_obstacle = false;  ///< by an obstacle that moves: a state of another time may lie beyond it
  bool has_load_energy = false;      ///< a load whose forces are -dU/dq of `energy_at` at each time, also if it changes
  bool rotates_with_body = true;     ///< its stiffness rotates with the body, as elastic stiffness does
  bool is_wall = false;              ///< its barrier separates states: no step may jump over it
  bool is_two_sided = false;         ///< a wall beyond which its energy is finite again: only a path shows a crossing
  bool dissipates = false;           ///< it may dissipate energy; the ledger lists that under the term's name
  bool dissipates_by_state = false;  ///< by `dissipated`
};

/// A viscous force has no potential over a stage, and a Hessian that is not symmetric.
inline constexpr TermDeclaration viscous_force{
    .is_potential = false, .symmetry = Symmetry::unsymmetric, .dissipates = true};

/// Where internal variables belong: EnergyTerm::internal_components of them.
struct InternalPlace {
  PetscInt cell = 0;              ///< local
  std::array<double, 3> point{};  ///< on the reference cell
  int number = 0;                 ///< index among those of the term at this point
};

/// Components of a symmetric tensor: xx yy zz xy yz xz.
inline constexpr int num_symmetric = 6;

/// The forces of frozen coefficients, and their upper bound, summed over points [N].
struct DragBound {
  double exerted = 0.0, allowed = 0.0;
};

/// Multipliers of what a stage computes: derivatives of a number that depends on it (docs/theory.md, "The adjoint of a
/// run").
struct StageMultipliers {
  std::span<const double> residual;  ///< of dPhi/dq, per local entry
  std::span<const double> internal;  ///< of the term's own internal variables at the end of the stage
};

/// Where the products of the multipliers with transposed derivatives are added, by what a stage depends on.
struct StageSlopes {
  std::span<double> q;       ///< of the internal variables alone: the residual's derivative is the Hessian
  std::span<double> q0, v0;  ///< of both, by the start of the stage
  std::span<double> z0;      ///< likewise, the term's own
};

/// One contribution to the incremental potential of a stage (docs/theory.md, "The incremental potential"). The arrays
/// span all local nodes, and those of patches of other ranks if it couples pairs; a term adds to the rows of owned
/// nodes completely (what it leaves in ghost rows is ignored), and counts energies of owned cells and nodes only, so
/// that a sum over ranks is the total. No method is collective.
class EnergyTerm {
 public:
  virtual ~EnergyTerm() = default;

  /// The kind of term; several terms of a sum may have the same name.
  virtual std::string_view name() const = 0;
  virtual TermDeclaration declaration() const = 0;

  /// Phi(q) of this rank's part [J] up to a constant of the stage: a difference from a state near q
  /// (LocalStage::reference() or q0), summed cell by cell with compensation, so that small changes survive next to
  /// large totals. +inf where a barrier is crossed.
  virtual double value(const LocalStage& stage, std::span<const double> q) const = 0;

  /// r += dPhi/dq [N]. NaN where a barrier is crossed.
  virtual void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const = 0;

  /// K += d2Phi/dq2 [N/m], rows of owned nodes.
  virtual void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                           Projection projection) const = 0;

  /// K = d2Phi/dq2 on the whole pattern, if that costs no more than clearing K. False: K is unchanged.
  virtual bool set_hessian(const LocalStage& /*stage*/, const BlockWriter& /*K*/) const { return false; }

  /// Numbers of internal variables on this rank (those of ghost cells included, computed there too): symmetric tensors
  /// or single numbers at points of cells.
  virtual std::size_t num_internal() const { return 0; }
  /// How many of them belong to one place: num_symmetric or 1.
  virtual int internal_components() const { return num_symmetric; }
  /// Their places.
  virtual void place_internal(std::span<InternalPlace> /*places*/) const {}
  /// z = the internal variables at the end of the stage with the solution q.
  virtual void end_stage(const LocalStage& /*stage*/, std::span<const double> /*q*/, std::span<double> /*z*/) const {}
  /// Sets those of z that do not follow from the method's formula: functions of q, and of q and the variables of the
  /// last accepted state, `accepted_z` (empty at the start). Leaves the others as the method set them.
  virtual void complete_step(std::span<const double> /*accepted_z*/, std::span<const double> /*q*/,
                             std::span<double> /*z*/) const {}

  /// Energy of the owned cells or nodes, if the account is `stored` or the term `has_load_energy` [J].
  virtual double energy(std::span<const double> /*q*/, std::span<const double> /*z*/) const { return 0.0; }
  /// Likewise at an instant, for terms whose energy depends explicitly on time [J].
  virtual double energy_at(const Instant& /*at*/, std::span<const double> q, std::span<const double> z) const {
    return energy(q, z);
  }
  /// Power that enters the energy of the owned cells by its explicit time dependence, dU/dt at fixed q at the end of
  /// the stage [W]: work from outside of mechanics.
  virtual double supply(const LocalStage& /*stage*/, std::span<const double> /*q*/) const { return 0.0; }
  /// Power that the owned cells dissipate by physical mechanisms at the end of the stage [W], >= 0.
  virtual double dissipation(const LocalStage& /*stage*/, std::span<const double> /*q*/) const { return 0.0; }

  /// What the owned cells have dissipated, if it is a function of the internal variables alone
  /// (`dissipates_by_state`), as of a mechanism that does not depend on rates [J]; not part of `dissipation`.
  virtual double dissipated(std::span<const double> /*z*/) const { return 0.0; }

  /// For a term with coefficients frozen at the step's start (`has_frozen_coefficients`): its forces at q with those
  /// coefficients, on this rank.
  virtual DragBound bound(const LocalStage& /*stage*/, std::span<const double> /*q*/) const { return {}; }

  /// Whether adjoints know the term: its forces depend on q and time alone and have a symmetric Hessian, or it has the
  /// functions that follow.
  virtual bool has_adjoint() const { return false; }
  /// Adds (dr/dy)^T m.residual + (dz/dy)^T m.internal for each y of the slopes, rows of owned nodes completely; z at
  /// the end of the stage (`end_stage`).
  virtual void pull_back(const LocalStage& /*stage*/, std::span<const double> /*q*/, const StageMultipliers& /*m*/,
                         const StageSlopes& /*slopes*/) const {}
  /// The same for `complete_step`: multipliers of z become those of what the method's formula set, and (dz/dq)^T z is
  /// added to r.
  virtual void pull_back_completion(std::span<const double> /*q*/, std::span<double> /*z*/,
                                    std::span<double> /*r*/) const {}
  /// r += (dr/dq)^T d - K d, K the Hessian, of a term without a potential.
  virtual void add_transposed_rest(const LocalStage& /*stage*/, std::span<const double> /*q*/,
                                   std::span<const double> /*d*/, std::span<double> /*r*/) const {}
  /// works += dPhi/dq . d of each local cell [J], for terms that are integrals over cells of bodies.
  virtual void add_cell_works(const LocalStage& /*stage*/, std::span<const double> /*q*/, std::span<const double> /*d*/,
                              std::span<double> /*works*/) const {}

  /// Whether the force on an owned node counts in the term's resultant (TermPower::force).
  virtual bool is_measured_at(PetscInt /*node*/) const { return true; }

  /// What it couples; several terms may share one. The same at all times.
  virtual Coupling coupling() const { return CellCoupling{}; }

  /// For a moving barrier: the displacements by which its motion since the step's start carries the local nodes from
  /// LocalStage::accepted, and for each node the closeness of the barrier, 1 where it would be touched. Both keep
  /// their values where another barrier is closer.
  virtual void follow_obstacle(const LocalStage& /*stage*/, std::span<Vector3<double>> /*displacements*/,
                               std::span<double> /*closeness*/) const {}

  /// The largest alpha for which q + alpha d does not cross the term's barrier; +inf if it has none.
  virtual double max_step(const LocalStage& /*stage*/, std::span<const double> /*q*/,
                          std::span<const double> /*d*/) const {
    return std::numeric_limits<double>::infinity();
  }
};

}  // namespace pliant
