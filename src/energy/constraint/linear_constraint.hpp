/// Linear constraints among displacements (ties; multi-point constraints, MPC), and their elimination.
#pragma once

#include "base/vector3.hpp"
#include "energy/given_motion.hpp"
#include "petsc/handle.hpp"

#include <optional>
#include <span>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

namespace pliant {

/// weight * u_component(X, t) of a prescribed displacement, which is identified by its index in a list.
struct GivenTerm {
  double weight = 1.0;
  std::size_t source = 0;
  int component = 0;
  Vector3<double> X{};
};

/// An entry of the configuration, with its number over all ranks (3 * global node + component), and its coefficient.
struct ConstraintEntry {
  PetscInt entry = 0;
  double coefficient = 1.0;
};

/// sum_k c_k q_k = the sum of the given terms [m].
struct LinearConstraint {
  std::vector<ConstraintEntry> entries;
  std::vector<GivenTerm> given;
  std::size_t source = 0;  ///< index of the constraint in the input that it comes from
};

/// q_slave = sum_m c_m q_m + given; no master is a slave.
struct Slave {
  PetscInt entry = 0;
  std::vector<ConstraintEntry> masters;
  std::vector<GivenTerm> given;
  std::size_t source = 0;
};

/// The result of the elimination: slaves that follow from other entries.
struct Elimination {
  std::vector<Slave> slaves;  ///< in the order of the constraints that they come from
  /// Sources of constraints that conflict.
  std::vector<std::pair<std::size_t, std::size_t>> conflicts;
};

/// Gaussian elimination, constraint by constraint: the slave of each constraint is the entry with the largest
/// coefficient after substituting the earlier constraints, the first of several: of its own entries, then of those that
/// were substituted. Nothing depends on the numbers of the entries. A constraint that the earlier ones
/// imply gives no slave; one that conflicts with them at one of the `times` is reported. Chains of any length are
/// resolved. Not collective.
class Eliminator {
 public:
  /// Both outlive the object.
  Eliminator(std::span<const GivenDisplacement> given, std::span<const double> times) : given_(given), times_(times) {}

  /// `slave`: preferred as the slave wherever its coefficient is not small.
  void add(const LinearConstraint& constraint, std::optional<PetscInt> slave = std::nullopt);
  /// The entry as a slave of the constraints so far; nullptr if it is none. Valid until the next `add`.
  const Slave* find(PetscInt entry) const;
  Elimination take() &&;

 private:
  bool vanishes(const std::vector<GivenTerm>& terms) const;
  /// In slaves that have the new slave as a master, replaces it by its own masters.
  void put_into_others(const Slave& slave);

  std::span<const GivenDisplacement> given_;
  std::span<const double> times_;
  Elimination result_;
  std::unordered_map<PetscInt, std::size_t> slave_of_;                       // by entry
  std::unordered_map<PetscInt, std::unordered_set<std::size_t>> slaves_of_;  // by master
};

/// The elimination of all of them, in this order. Not collective.
Elimination eliminate(std::span<const LinearConstraint> constraints, std::span<const GivenDisplacement> given,
                      std::span<const double> times);

/// Gathers the constraints of all ranks, in rank order, on every rank. Collective.
std::vector<LinearConstraint> gathered(MPI_Comm comm, std::span<const LinearConstraint> mine);

}  // namespace pliant
