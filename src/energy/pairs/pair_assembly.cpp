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
    : layout_(layout), prescribed_(prescribed.begin(), prescribed.end()) {
  for (const PairCoupling* coupling : couplings) {
    on_path_.push_back({*coupling, {}, {}, {}});
    frozen_.push_back({*coupling, {}, {}, {}});
  }
  forget();
}

void PairAssembly::forget() {
  for (Pursuit& pursuit : on_path_) pursuit.search.emplace(layout_, pursuit.coupling);
  for (Pursuit& pursuit : frozen_) {
    pursuit.search.reset();
    pursuit.found = {};
    pursuit.near = {};
  }
  far_.emplace(layout_, std::vector<PetscInt>{});
  pattern_.emplace(layout_);
  elimination_.emplace(layout_, *pattern_, std::vector<char>(prescribed_.begin(), prescribed_.end()));
  is_fitted_ = false;
}

double PairAssembly::searchable_part(std::span<const double> d) const {
  double part = 1.0;
  for (const Pursuit& pursuit : on_path_) part = std::min(part, pursuit.search->searchable_part(d));
  return minimum(layout_.comm, part);
}

bool PairAssembly::follow(const Path& path, std::span<const std::span<const double>> frozen) {
  std::vector<std::pair<Pursuit*, Path>> pursuits;
  for (Pursuit& pursuit : on_path_) pursuits.emplace_back(&pursuit, path);
  for (std::size_t k = 0; k < frozen.size(); ++k) pursuits.emplace_back(&frozen_[k], Path{frozen[k]});
  std::vector<double> is_left;  // on how many ranks
  for (const auto& [pursuit, of] : pursuits) {
    const bool is_covered = of.q.empty() || (pursuit->search && pursuit->search->covers(of));
    is_left.push_back(is_covered ? 0.0 : 1.0);
  }
  sum_in_place(layout_.comm, is_left);
  if (std::ranges::none_of(is_left, [](double ranks) { return ranks > 0.0; })) return false;
  for (std::size_t n = 0; n < pursuits.size(); ++n) {
    if (is_left[n] == 0.0) continue;
    auto& [pursuit, of] = pursuits[n];
    if (!pursuit->search) pursuit->search.emplace(layout_, pursuit->coupling);
    pursuit->found = pursuit->search->search(of);
  }
  std::vector<PetscInt> needed;
  for (const std::vector<Pursuit>* all : {&on_path_, &frozen_}) {
    for (const Pursuit& pursuit : *all) {
      needed.insert(needed.end(), pursuit.found.global_nodes.begin(), pursuit.found.global_nodes.end());
    }
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

  for (std::vector<Pursuit>* all : {&on_path_, &frozen_}) {
    for (Pursuit& pursuit : *all) {
      if (pursuit.search) pursuit.near = near_of(pursuit);
    }
  }
  return true;
}

NearPatches PairAssembly::near_of(const Pursuit& pursuit) const {
  const FoundPatches& found = pursuit.found;
  Patches patches = pursuit.coupling.patches();
  patches.keys = found.keys;
  patches.tags = found.tags;
  patches.is_owned.resize(patches.keys.size(), 0);
  for (const PetscInt node : found.global_nodes) patches.nodes.push_back(far_->local_node(node));
  NearPatches near{std::move(patches), found.pairs, coordinates_, layout_.num_owned_nodes, nullptr};
  near.features = pursuit.coupling.features_of(near);
  return near;
}

template <class Visit>
bool PairAssembly::all_coupled_nodes(const Visit& visit) const {
  const auto visit_all = [&](const NearPatches& near, const PairCoupling& coupling) {
    for (const PatchPair& pair : near.pairs) {
      if (!coupling.couples(near.patches.keys[pair.first], near.patches.keys[pair.second])) continue;
      for (const PetscInt a : near.patches.nodes_of(pair.first)) {
        for (const PetscInt b : near.patches.nodes_of(pair.second)) {
          if (near.is_owned(a) && !visit(a, b)) return false;
          if (near.is_owned(b) && !visit(b, a)) return false;
        }
      }
    }
    return true;
  };
  const auto is_done = [&](const Pursuit& pursuit) { return visit_all(pursuit.near, pursuit.coupling); };
  return std::ranges::all_of(on_path_, is_done) && std::ranges::all_of(frozen_, is_done);
}

bool PairAssembly::fit() {
  if (is_fitted_) return false;
  is_fitted_ = true;
  const auto is_known = [&](PetscInt row, PetscInt column) { return pattern_->contains(row, column); };
  if (!any_rank(layout_.comm, !pattern_ || !all_coupled_nodes(is_known))) return false;
  std::vector<std::pair<PetscInt, PetscInt>> coupled;
  all_coupled_nodes([&](PetscInt row, PetscInt column) {
    coupled.emplace_back(row, column);
    return true;
  });
  std::ranges::sort(coupled);
  coupled.erase(std::unique(coupled.begin(), coupled.end()), coupled.end());
  pattern_.emplace(layout_, FarCouplings{far_->globals(), std::move(coupled)});
  std::vector<double> flags;
  far_->extend(prescribed_, flags);
  elimination_.emplace(layout_, *pattern_, std::vector<char>(flags.begin(), flags.end()));
  return true;
}

}  // namespace pliant
