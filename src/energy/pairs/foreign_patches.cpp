#include "energy/pairs/foreign_patches.hpp"

#include "petsc/collective.hpp"
#include "petsc/exchange.hpp"
#include "petsc/session.hpp"

#include <algorithm>

namespace pliant {
namespace {

/// About as many boxes as a rank sends to the others, of all kinds.
constexpr std::size_t num_part_boxes = 64;

/// A box that holds those of some patches of a rank.
struct PartBox {
  Box box;
  std::int32_t kind = 0, rank = 0;
};

std::vector<PartBox> part_boxes(std::span<const KindTree> trees, std::int32_t of_rank) {
  const auto num_trees = std::ranges::count_if(trees, [](const KindTree& of) { return of.tree.size() > 0; });
  const std::size_t num_each = num_part_boxes / std::max<std::size_t>(1, static_cast<std::size_t>(num_trees));
  std::vector<PartBox> parts;
  for (std::size_t kind = 0; kind < trees.size(); ++kind) {
    for (const Box& box : trees[kind].tree.cover(num_each)) {
      parts.push_back({box, static_cast<std::int32_t>(kind), of_rank});
    }
  }
  return parts;
}

/// For each rank, those of this rank's own patches that overlap one of its boxes, ascending.
std::vector<std::vector<std::int32_t>> patches_for(std::span<const PartBox> parts, std::size_t num_ranks_there,
                                                   std::int32_t me, const PatchKinds& kinds, const LocalPatches& mine) {
  std::vector<std::vector<std::int32_t>> sent(num_ranks_there);
  std::vector<std::int32_t> sent_to(mine.patches.size(), -1);  // the last rank; parts come rank by rank
  for (const PartBox& part : parts) {
    if (part.rank == me) continue;
    for (std::size_t kind = 0; kind < kinds.size(); ++kind) {
      if (!kinds.may_couple(static_cast<std::int32_t>(kind), part.kind)) continue;
      mine.trees[kind].tree.for_each_overlap(part.box, [&](std::int32_t n) {
        const std::int32_t patch = mine.trees[kind].patches[n];
        if (!mine.patches.is_owned[patch] || sent_to[patch] == part.rank) return;
        sent_to[patch] = part.rank;
        sent[part.rank].push_back(patch);
      });
    }
  }
  for (auto& patches : sent) std::ranges::sort(patches);
  return sent;
}

}  // namespace

ForeignPatches foreign_patches_near(const NodeLayout& layout, const PatchKinds& kinds, const LocalPatches& mine) {
  const auto num_ranks_there = static_cast<std::size_t>(num_ranks(layout.comm));
  if (num_ranks_there == 1) return {};
  const std::int32_t me = rank(layout.comm);
  const std::vector<PartBox> parts = gathered(layout.comm, part_boxes(mine.trees, me));
  const auto patches = patches_for(parts, num_ranks_there, me, kinds, mine);
  std::vector<std::vector<ForeignPatch>> sent(num_ranks_there);
  std::vector<std::vector<PetscInt>> sent_nodes(num_ranks_there);
  for (std::size_t r = 0; r < num_ranks_there; ++r) {
    for (const std::int32_t patch : patches[r]) {
      sent[r].push_back({mine.patches.keys[patch], mine.kinds[patch], 0, mine.boxes[patch]});
      for (const PetscInt node : mine.patches.nodes_of(static_cast<std::size_t>(patch))) {
        sent_nodes[r].push_back(layout.global_node(node));
      }
    }
  }
  ForeignPatches foreign{exchanged(layout.comm, sent), exchanged(layout.comm, sent_nodes)};
  for (std::size_t n = 0; n < foreign.patches.size(); ++n) foreign.patches[n].place = static_cast<std::int32_t>(n);
  std::ranges::sort(foreign.patches, {}, &ForeignPatch::key);
  return foreign;
}

}  // namespace pliant
