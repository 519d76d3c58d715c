#include "energy/pairs/pair_assembly.hpp"

#include "petsc/collective.hpp"

#include <algorithm>
#include <iterator>

namespace pliant {
namespace {

/// Far nodes are kept, though no longer near, up to this many times those that are: the fewer patterns.
constexpr std::size_t most_kept = 2;

}  // namespace

PairAssembly::PairAssembly(const NodeLayout& layout, std::vector<const PairCoupling*> couplings,
                           const std::vector<char>& prescribed)
    : layout_(layout),
      couplings_(std::move(couplings)),
      prescribed_(prescribed.begin(), prescribed.end()),
      near_(couplings_.size()) {
  forget();
}

void PairAssembly::forget() {
  searches_.clear();
  for (const PairCoupling* coupling : couplings_) searches_.emplace_back(layout_, *coupling);
  far_.emplace(layout_, std::vector<PetscInt>{});
  pattern_.emplace(layout_);
  elimination_.emplace(layout_, *pattern_, std::vector<char>(prescribed_.begin(), prescribed_.end()));
  is_fitted_ = false;
}

double PairAssembly::searchable_part(std::span<const double> d) const {
  double part = 1.0;
  for (const PatchSearch& search : searches_) part = std::min(part, search.searchable_part(d));
  return minimum(layout_.comm, part);
}

bool PairAssembly::follow(const Path& path) {
  const auto is_left = [&](const PatchSearch& search) { return !search.covers(path); };
  if (!any_rank(layout_.comm, std::ranges::any_of(searches_, is_left))) return false;
  std::vector<FoundPatches> found;
  std::vector<PetscInt> needed;
  for (PatchSearch& search : searches_) {
    found.push_back(search.search(path));
    for (const PetscInt node : found.back().global_nodes) needed.push_back(node);
  }
  const auto is_of_layout = [&](PetscInt global) {
    const PetscInt owned = global - layout_.first_global_node;
    return (owned >= 0 && owned < layout_.num_owned_nodes) ||
           std::ranges::binary_search(layout_.ghost_global_nodes, global);
  };
  std::erase_if(needed, is_of_layout);
  std::ranges::sort(needed);
  needed.erase(std::unique(needed.begin(), needed.end()), needed.end());

  const std::vector<PetscInt>& before = far_->globals();
  std::vector<PetscInt> both;
  std::ranges::set_union(before, needed, std::back_inserter(both));
  if (both.size() > most_kept * needed.size()) both = needed;
  if (any_rank(layout_.comm, both != before)) {
    far_.emplace(layout_, std::move(both));
    pattern_.reset();
  }
  far_->extend(layout_.coordinates, coordinates_);
  is_fitted_ = false;

  for (std::size_t k = 0; k < couplings_.size(); ++k) {
    Patches patches = couplings_[k]->patches();
    patches.keys = std::move(found[k].keys);
    patches.tags = std::move(found[k].tags);
    patches.is_owned.resize(patches.keys.size(), 0);
    for (const PetscInt node : found[k].global_nodes) patches.nodes.push_back(far_->local_node(node));
    near_[k] = {std::move(patches), std::move(found[k].pairs), coordinates_, layout_.num_owned_nodes};
  }
  return true;
}

std::vector<std::pair<PetscInt, PetscInt>> PairAssembly::coupled_nodes() const {
  std::vector<std::pair<PetscInt, PetscInt>> result;
  for (const NearPatches& near : near_) {
    for (const PatchPair& pair : near.pairs) {
      for (const PetscInt a : near.patches.nodes_of(pair.first)) {
        for (const PetscInt b : near.patches.nodes_of(pair.second)) {
          if (near.is_owned(a)) result.emplace_back(a, b);
          if (near.is_owned(b)) result.emplace_back(b, a);
        }
      }
    }
  }
  std::ranges::sort(result);
  result.erase(std::unique(result.begin(), result.end()), result.end());
  return result;
}

bool PairAssembly::fit() {
  if (is_fitted_) return false;
  is_fitted_ = true;
  auto coupled = coupled_nodes();
  const bool is_contained = pattern_ && std::ranges::all_of(coupled, [&](const auto& pair) {
                              return pattern_->contains(pair.first, pair.second);
                            });
  if (!any_rank(layout_.comm, !is_contained)) return false;
  pattern_.emplace(layout_, FarCouplings{far_->globals(), std::move(coupled)});
  std::vector<double> flags;
  far_->extend(prescribed_, flags);
  elimination_.emplace(layout_, *pattern_, std::vector<char>(flags.begin(), flags.end()));
  return true;
}

}  // namespace pliant
