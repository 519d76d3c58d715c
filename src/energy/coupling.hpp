/// What a term couples: the nodes of each cell, what comes near one another, or all nodes of a sum.
#pragma once

#include "base/vector3.hpp"
#include "fem/block_matrix.hpp"

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <variant>
#include <vector>

namespace pliant {

class FunctionOfSum;
class PairCoupling;
struct LocalStage;

/// The term couples nodes that share a cell (or a facet of one): the pattern that every Hessian has.
struct CellCoupling {};

/// The term is a function of a sum over all ranks of what patches near one another have: the length of a string.
struct SumOverPairs {
  const FunctionOfSum* sum = nullptr;
  const PairCoupling* pairs = nullptr;
};

/// What a term couples, and therefore what the sum of the terms (IncrementalPotential) does for it: nothing beyond the
/// ghosts and the matrix pattern of the cells; sums over all ranks, and rank-one terms of the Hessian
/// (energy/function_of_sum.hpp); pairs, the nodes of other ranks that they need, and a pattern that follows them; or
/// both.
using Coupling = std::variant<CellCoupling, const FunctionOfSum*, const PairCoupling*, SumOverPairs>;

/// The sum over all ranks that it is a function of; nullptr: none.
inline const FunctionOfSum* function_of_sum(const Coupling& coupling) {
  if (const auto* sum = std::get_if<const FunctionOfSum*>(&coupling)) return *sum;
  const auto* both = std::get_if<SumOverPairs>(&coupling);
  return both != nullptr ? both->sum : nullptr;
}

/// The pairs that it couples; nullptr: none.
inline const PairCoupling* pair_coupling(const Coupling& coupling) {
  if (const auto* pairs = std::get_if<const PairCoupling*>(&coupling)) return *pairs;
  const auto* both = std::get_if<SumOverPairs>(&coupling);
  return both != nullptr ? both->pairs : nullptr;
}

/// A point that moves with three nodes of a patch, by constant weights whose sum is 1.
struct PatchPoint {
  std::array<std::uint8_t, 3> nodes{};  ///< among those of the patch
  std::array<double, 3> weights{1.0, 0.0, 0.0};
};

/// Sets of nodes that couple as a whole with what comes near them: nodes, edges or facets of surfaces. A rank lists
/// those with at least one node of its own; the same patch may stand on several ranks.
struct Patches {
  int nodes_per_patch = 1;
  /// The patch lies within the hull of these, of its nodes where there are none.
  int points_per_patch = 0;
  std::vector<PatchPoint> points;  ///< points_per_patch of each of this rank's patches
  std::vector<PetscInt> nodes;     ///< local, nodes_per_patch of each
  std::vector<std::int64_t> keys;  ///< number of each patch, the same on all ranks, different for each
  std::vector<int> tags;           ///< of each, whatever the term wants to know of it on other ranks: its body
  std::vector<char> is_owned;      ///< of each: whether this rank counts it; exactly one rank does

  std::size_t size() const { return keys.size(); }
  std::span<const PetscInt> nodes_of(std::size_t patch) const {
    const auto n = static_cast<std::size_t>(nodes_per_patch);
    return std::span(nodes).subspan(patch * n, n);
  }
};

/// Two patches that may be within reach of each other; numbers among NearPatches::patches. The first has the lower key.
struct PatchPair {
  std::size_t first = 0, second = 0;
};

/// What a coupling derives from the patches that are near one another, once for all configurations between two searches
/// (PairCoupling::features_of).
class PairFeatures {
 public:
  virtual ~PairFeatures() = default;
};

/// What a rank sees of the patches: its own in the order of PairCoupling::patches, then those of other ranks that are
/// near one of its own, by their keys. Their nodes are local ones, among which nodes of other ranks that no cell of
/// this rank has come last; arrays of LocalStage and the q of a call span all of them.
struct NearPatches {
  Patches patches;
  /// All pairs with a patch of this rank whose distance may be below the reach, ascending in their keys; for a step
  /// bound (EnergyTerm::max_step), anywhere between q and the end of the path (StageArrays::along). Which others are
  /// among them depends on what was evaluated before, so nothing may depend on it. Patches that share nodes are among
  /// them where the tags say so.
  std::vector<PatchPair> pairs;
  std::span<const double> coordinates;  ///< xyz of all local nodes in the reference configuration [m]
  PetscInt num_owned_nodes = 0;
  std::shared_ptr<const PairFeatures> features;  ///< PairCoupling::features_of

  Vector3<double> position(PetscInt node, std::span<const double> q) const {
    const auto i = 3 * static_cast<std::size_t>(node);
    return {coordinates[i] + q[i], coordinates[i + 1] + q[i + 1], coordinates[i + 2] + q[i + 2]};
  }
  bool is_owned(PetscInt node) const { return node < num_owned_nodes; }
};

/// Pairs that are the same in all configurations, as those of a mesh.
struct FixedPairs {
  /// The patches of other ranks that they need, by their keys, their nodes and tags.
  std::vector<std::int64_t> keys;
  std::vector<PetscInt> global_nodes;
  std::vector<int> tags;
  std::vector<PatchPair> pairs;  ///< of this rank's patches, then those; ascending in their keys
};

/// A term of pairs that change with the configuration: contact between bodies. Its forces vanish smoothly at the reach,
/// so that it does not matter when a pair is found. Every rank evaluates all pairs that have a node of its own, so that
/// nothing is sent back; energies of a pair are counted where its first patch is owned. The term adds blocks of the
/// Hessian by `BlockWriter::add(row, column, block)`.
class PairCoupling {
 public:
  virtual ~PairCoupling() = default;

  /// Those of this rank.
  virtual const Patches& patches() const = 0;
  /// The distance from which patches do not feel each other [m], > 0; the same on every rank.
  virtual double reach() const = 0;
  /// About how far patches may move before they are searched anew [m], > 0; the same on every rank.
  virtual double slack() const { return reach(); }
  /// Whether two patches with these tags may couple at all; symmetric. Asked once for any two tags, of which there are
  /// to be few: those of bodies, not of patches.
  virtual bool may_couple(int tag, int other) const = 0;
  /// Pairs that do not follow from what is near: nothing is searched then, and reach, slack and may_couple say nothing.
  /// nullptr: those that are near one another.
  virtual const FixedPairs* fixed_pairs() const { return nullptr; }
  /// Whether the nodes of two patches of these keys, which are near each other, couple, or one of them is known only
  /// because it may decide what others do; symmetric.
  virtual bool couples(std::int64_t /*key*/, std::int64_t /*other*/) const { return true; }
  /// What its terms need to know of these patches and pairs besides positions; nullptr: nothing.
  virtual std::shared_ptr<const PairFeatures> features_of(const NearPatches& /*near*/) const { return nullptr; }
  /// A configuration in addition to the q of a call whose pairs the term needs too (LocalStage::near_frozen); empty:
  /// none.
  virtual std::span<const double> frozen_place(const LocalStage& /*stage*/, std::span<const double> /*q*/) const {
    return {};
  }
};

}  // namespace pliant
