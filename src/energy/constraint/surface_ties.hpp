/// Kinds of linear constraints on selections of nodes: ties of surfaces, means, directions.
#pragma once

#include "energy/constraint/linear_constraint.hpp"
#include "fem/layout.hpp"

#include <array>
#include <string>
#include <vector>

namespace pliant {

/// direction . u = the first component of the prescribed displacement `source`, at each of the owned nodes. Not
/// collective.
std::vector<LinearConstraint> ties_along(const NodeLayout& layout, std::span<const PetscInt> nodes,
                                         const Vector3<double>& direction, std::size_t source);

/// Pairs of nodes of two surfaces that a translation maps onto each other.
struct PeriodicPairs {
  struct Pair {
    PetscInt a, b;  ///< global nodes, X_b = X_a + translation
    Vector3<double> X_b;
  };
  std::vector<Pair> pairs;  ///< in the order of b in the list of all ranks' nodes; the same on every rank
  Vector3<double> translation{};
  /// Number of nodes of either surface without a partner, and one of them.
  std::size_t num_unmatched_a = 0, num_unmatched_b = 0;
  Vector3<double> unmatched{};
};

/// Matches the owned nodes of two surfaces, to 1e-6 of their extent; the translation maps the lower corner of one
/// bounding box to that of the other. Collective.
PeriodicPairs match_periodic(const NodeLayout& layout, std::span<const PetscInt> nodes_a,
                             std::span<const PetscInt> nodes_b);

/// u_b - u_a = the components of the prescribed displacement `source`, for all pairs; a component that it does not
/// prescribe is free, but the same for all pairs. The same on every rank. Not collective.
std::vector<LinearConstraint> periodic(const PeriodicPairs& pairs, const GivenDisplacement& given, std::size_t source);

/// u_a - u_m = the difference that the prescribed rigid motion `source` gives, for the components in which its
/// translation is free, at the owned nodes; m is the first of all nodes. Collective.
std::vector<LinearConstraint> translated_together(const NodeLayout& layout, std::span<const PetscInt> nodes,
                                                  const GivenDisplacement& given, std::size_t source);

/// A component of the mean displacement of some owned nodes, and its coefficient.
struct MeanTerm {
  std::vector<PetscInt> nodes;
  int component = 0;
  double coefficient = 1.0;
};

/// sum of the terms = the first component of the prescribed displacement `source`. The same on every rank. Collective.
LinearConstraint tie_of_means(const NodeLayout& layout, std::span<const MeanTerm> terms, std::size_t source);

}  // namespace pliant
