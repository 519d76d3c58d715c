/// What the sum of the terms does for those of them that couple pairs (energy/coupling.hpp).
#pragma once

#include "energy/coupling.hpp"
#include "energy/pairs/far_nodes.hpp"
#include "energy/pairs/patch_search.hpp"
#include "fem/block_matrix.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
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
  /// Brings the pairs to the path: no pair that comes within reach on it is missed. `frozen`: of each coupling, another
  /// configuration whose pairs it needs, or none (PairCoupling::frozen_place). True if pairs have changed, and with
  /// them the far nodes: arrays are to be extended anew. Collective.
  bool follow(const Path& path, std::span<const std::span<const double>> frozen = {});
  /// The pairs of each coupling, in their order, since the last call of `follow`: on the path, and at `frozen`.
  const NearPatches& near(std::size_t coupling) const { return on_path_[coupling].near; }
  const NearPatches& near_frozen(std::size_t coupling) const { return frozen_[coupling].near; }
  /// Goes back to what it was when made: the next `follow` searches anew, and the pattern is that of the cells.
  void forget();
  std::size_t num_far_nodes() const { return far_->globals().size(); }
  /// FarNodes::extend. Collective.
  void extend(std::span<const double> local, std::vector<double>& all) const { far_->extend(local, all); }

  /// The pattern of cells and pairs, and the elimination of prescribed entries from it; made and renewed by `fit`.
  const BlockPattern& pattern() const { return *pattern_; }
  const RowElimination& elimination() const { return *elimination_; }
  /// Extends the pattern to all pairs that are near; false if it contains them already. Collective.
  bool fit();

 private:
  using KeyPair = std::pair<std::int64_t, std::int64_t>;
  /// Pairs at one place or along one path, and the search for them.
  struct Pursuit {
    const PairCoupling& coupling;
    std::optional<PatchSearch> search;  // not before it is needed
    FoundPatches found;                 // by the last search
    NearPatches near;                   // the same, with the far nodes as they are
    std::vector<KeyPair> fitted;        // whose nodes the pattern contains, of pairs by their keys; ascending
  };
  NearPatches near_of(const Pursuit& pursuit) const;
  /// The pairs near that the pattern is not known to contain, in their order.
  static std::vector<PatchPair> new_pairs(const Pursuit& pursuit);
  /// Notes that the pattern contains these pairs; they are near, and new to `fitted`.
  static void note_fitted(Pursuit& pursuit, std::span<const PatchPair> pairs);

  const NodeLayout& layout_;
  std::vector<double> prescribed_;         // of entries, 0 or 1
  std::vector<Pursuit> on_path_, frozen_;  // of each coupling
  std::optional<FarNodes> far_;
  std::vector<double> coordinates_;  // of local and far nodes
  std::optional<BlockPattern> pattern_;
  std::optional<RowElimination> elimination_;
  bool has_new_far_nodes_ = false;  // which the pattern does not know
  bool is_fitted_ = false;          // the pattern contains what is near
};

}  // namespace pliant
