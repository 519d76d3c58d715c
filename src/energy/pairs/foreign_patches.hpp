/// Patches of other ranks that may be near those of this one.
#pragma once

#include "collision/bvh.hpp"
#include "energy/coupling.hpp"
#include "energy/pairs/patch_kinds.hpp"
#include "fem/layout.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace pliant {

/// This rank's patches of one kind, and the tree of their boxes.
struct KindTree {
  std::vector<std::int32_t> patches;
  Bvh tree;
};

/// What a rank knows of its own patches.
struct LocalPatches {
  const Patches& patches;
  std::span<const std::int32_t> kinds;  ///< of each
  std::span<const Box> boxes;           ///< of each
  std::span<const KindTree> trees;      ///< of each kind
};

/// A patch that another rank owns.
struct ForeignPatch {
  std::int64_t key = 0;
  std::int32_t kind = 0;
  std::int32_t place = 0;  ///< where its nodes begin, in units of nodes_per_patch
  Box box;
};
struct ForeignPatches {
  std::vector<ForeignPatch> patches;   ///< by their keys
  std::vector<PetscInt> global_nodes;  ///< nodes_per_patch of each, at its place
};

/// All patches owned by other ranks whose boxes overlap one of this rank's and that may couple with it, and some more.
/// Ranks send each other a few boxes that hold those of their patches, and send what overlaps them: what lies within a
/// rank stays there. Patches that this rank lists itself may be among them. Collective.
ForeignPatches foreign_patches_near(const NodeLayout& layout, const PatchKinds& kinds, const LocalPatches& mine);

}  // namespace pliant
