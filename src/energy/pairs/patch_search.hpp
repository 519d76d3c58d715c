/// Which patches of all ranks are near one another (energy/coupling.hpp).
#pragma once

#include "collision/box.hpp"
#include "energy/coupling.hpp"
#include "energy/pairs/foreign_patches.hpp"
#include "energy/pairs/patch_kinds.hpp"
#include "fem/layout.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace pliant {

/// A straight path of all nodes: the displacements q + t d, 0 <= t <= end. Without d it is the point q. The arrays span
/// the nodes of the layout at least.
struct Path {
  std::span<const double> q, d = {};
  double end = 1.0;
};

/// What a search leaves: this rank's patches, then those of other ranks that are near one of them, by their keys.
struct FoundPatches {
  std::vector<std::int64_t> keys;
  std::vector<int> tags;
  std::vector<PetscInt> global_nodes;  ///< of the patches of other ranks
  std::vector<PatchPair> pairs;        ///< NearPatches::pairs
};

/// Finds the pairs of one coupling (broad phase of contact). Each node has a box that holds its path and half of a skin
/// around it, each patch a box that holds those of its nodes and half of the reach around them; pairs are the patches
/// whose boxes overlap. They hold as long as every node stays within its box: no pair that comes within reach there is
/// missed. The skin follows how far nodes travel between searches.
///
/// Pairs that are fixed (PairCoupling::fixed_pairs) are taken as they are.
///
/// Patches of one kind have a tree of their own (collision/bvh.hpp), so that a body that does not couple with itself
/// costs nothing.
class PatchSearch {
 public:
  /// Both outlive the object. Collective.
  PatchSearch(const NodeLayout& layout, const PairCoupling& coupling);

  /// The largest t <= 1 for which q + t d may be searched as one path, as far as this rank's nodes are concerned: none
  /// moves by more than a length that follows from the reach and the sizes of the patches at rest. However long d is, a
  /// patch meets some hundred others at the most, on average. It depends on d alone, not on what was searched before;
  /// a search takes the least of all ranks. Not collective.
  double searchable_part(std::span<const double> d) const;

  /// Whether the last search holds on the path, as far as this rank's nodes are concerned, and was made for none that
  /// is much longer. Not collective.
  bool covers(const Path& path) const;
  /// Searches anew: no pair that comes within reach on the path is missed. Collective.
  FoundPatches search(const Path& path);

 private:
  void number_nodes();
  void limit_paths();
  Vector3<double> position(PetscInt node, std::span<const double> q) const;
  /// The largest component of a displacement d of this rank's nodes [m].
  double length(std::span<const double> d) const;
  void widen_skin(std::span<const double> q);
  void set_boxes(const Path& path);
  /// The box of a patch, from those of its nodes.
  template <class BoxOfNode>
  Box box_of_patch(std::size_t patch, const BoxOfNode& box_of_node) const;

  /// All pairs with a patch of this rank, of numbers in the order of all keys, sorted; `places` has these numbers of
  /// this rank's patches, then of the foreign ones.
  std::vector<BoxPair> find_pairs(std::span<const ForeignPatch> foreign, std::span<const std::int32_t> places) const;

  const NodeLayout& layout_;
  const PairCoupling& coupling_;
  PatchKinds kinds_;
  std::vector<std::int32_t> kind_of_patch_;
  std::vector<std::int32_t> order_;    // patches by their keys
  std::vector<PetscInt> nodes_;        // of all patches, each once, ascending
  std::vector<std::int32_t> corners_;  // nodes_per_patch of each patch, as numbers in nodes_
  double longest_path_ = 0.0;          // by which a node may move in one search [m]

  bool has_searched_ = false;
  double skin_;                   // [m]
  double searched_length_ = 0.0;  // by which a node of this rank moves on the path of the last search [m]
  std::vector<Box> node_boxes_;   // of nodes_, in the last search; empty before the first
  std::vector<Box> patch_boxes_;  // of each patch
  std::vector<KindTree> trees_;   // of each kind
};

}  // namespace pliant
