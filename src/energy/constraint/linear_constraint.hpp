/// Linear constraints that tie displacements to one another, and their elimination.
#pragma once

#include "base/vector3.hpp"
#include "energy/given_motion.hpp"
#include "petsc/handle.hpp"

#include <span>
#include <utility>
#include <vector>

namespace pliant {

/// weight * u_component(X, t) of a given displacement, which is known by its place in a list.
struct GivenTerm {
  double weight = 1.0;
  std::size_t source = 0;
  int component = 0;
  Vector3<double> X{};
};

/// An entry of the configuration, numbered over all ranks (3 * global node + component), and its coefficient.
struct ConstraintEntry {
  PetscInt entry = 0;
  double coefficient = 1.0;
};

/// sum_k c_k q_k = sum of the given terms [m].
struct LinearConstraint {
  std::vector<ConstraintEntry> entries;
  std::vector<GivenTerm> given;
  std::size_t source = 0;  ///< whose constraint it is
};

/// q_slave = sum_m c_m q_m + given; no master is a slave.
struct Slave {
  PetscInt entry = 0;
  std::vector<ConstraintEntry> masters;
  std::vector<GivenTerm> given;
  std::size_t source = 0;
};

/// What is left of constraints: slaves that follow from other entries.
struct Elimination {
  std::vector<Slave> slaves;  ///< in the order of the constraints that made them
  /// Sources of constraints that contradict each other.
  std::vector<std::pair<std::size_t, std::size_t>> conflicts;
};

/// Gauss's elimination: every constraint makes a slave of that entry which has the largest coefficient once the earlier
/// constraints are put in (the first of several); a constraint that the earlier ones imply makes none, and one that
/// they contradict at one of the `times` is reported. Chains of any length are thereby resolved. Not collective.
Elimination eliminate(std::span<const LinearConstraint> constraints, std::span<const GivenDisplacement> given,
                      std::span<const double> times);

/// The constraints of all ranks, rank by rank, on every rank. Collective.
std::vector<LinearConstraint> gathered(MPI_Comm comm, std::span<const LinearConstraint> mine);

}  // namespace pliant
