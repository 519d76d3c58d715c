/// What the sum of the terms does for those of them that couple pairs (energy/coupling.hpp).
#pragma once

#include "energy/coupling.hpp"
#include "energy/pairs/far_nodes.hpp"
#include "energy/pairs/patch_search.hpp"
#include "fem/block_matrix.hpp"

#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace pliant {

/// The pairs of some couplings, the far nodes that all of them need, and the pattern of a Hessian with both cells and
/// pairs. A pattern is kept as long as it contains what is near, so that factorizations seldom need another analysis.
class PairAssembly {
 public:
  /// `prescribed`: one flag per entry of the layout. The references outlive the object.
  PairAssembly(const NodeLayout& layout, std::vector<const PairCoupling*> couplings,
               const std::vector<char>& prescribed);

  /// The part of the displacement d, at most 1, to which pairs are followed in one search
  /// (PatchSearch::searchable_part). Collective.
  double searchable_part(std::span<const double> d) const;
  /// Brings the pairs to the path: no pair that comes within reach on it is missed. True if they have changed, and with
  /// them the far nodes: arrays are to be extended anew. Collective.
  bool follow(const Path& path);
  /// The pairs of each coupling, in their order, since the last call of `follow`.
  const NearPatches& near(std::size_t coupling) const { return near_[coupling]; }
  /// Goes back to what it was when made: the next `follow` searches anew, and the pattern is that of the cells.
  void forget();
  std::size_t num_far_nodes() const { return far_->globals().size(); }
  /// FarNodes::extend. Collective.
  void extend(std::span<const double> local, std::vector<double>& all) const { far_->extend(local, all); }

  /// The pattern of cells and pairs, and the elimination of prescribed entries from it; renewed by `fit`.
  const BlockPattern& pattern() const { return *pattern_; }
  const RowElimination& elimination() const { return *elimination_; }
  /// Extends the pattern to all pairs that are near; false if it contains them already. Collective.
  bool fit();

 private:
  /// Pairs of nodes that couple, the first owned.
  std::vector<std::pair<PetscInt, PetscInt>> coupled_nodes() const;

  const NodeLayout& layout_;
  std::vector<const PairCoupling*> couplings_;
  std::vector<double> prescribed_;  // of entries, 0 or 1
  std::vector<PatchSearch> searches_;
  std::vector<NearPatches> near_;
  std::optional<FarNodes> far_;
  std::vector<double> coordinates_;  // of local and far nodes
  std::optional<BlockPattern> pattern_;
  std::optional<RowElimination> elimination_;
  bool is_fitted_ = false;  // the pattern contains what is near
};

}  // namespace pliant
