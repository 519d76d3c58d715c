#include "energy/pairs/pair_assembly.hpp"

#include "petsc/collective.hpp"

#include <algorithm>
#include <iterator>
#include <numeric>

namespace pliant {
namespace {

/// Far nodes are kept, though no longer near, up to this many times those that are: the fewer patterns.
constexpr std::size_t most_kept = 2;

/// visit(node, node) of the nodes of these pairs that couple, the first owned, some of them repeatedly, until it
/// returns false: then so does this.
template <class Visit>
bool all_coupled_nodes(const NearPatches& near, const PairCoupling& coupling, std::span<const PatchPair> pairs,
                       const Visit& visit) {
  for (const PatchPair& pair : pairs) {
    if (!coupling.couples(near.patches.keys[pair.first], near.patches.keys[pair.second])) continue;
    for (const PetscInt a : near.patches.nodes_of(pair.first)) {
      for (const PetscInt b : near.patches.nodes_of(pair.second)) {
        if (near.is_owned(a) && !visit(a, b)) return false;
        if (near.is_owned(b) && !visit(b, a)) return false;
      }
    }
  }
  return true;
}

/// Those that `visit_all(visit)` visits, each once, ascending.
template <class VisitAll>
std::vector<std::pair<PetscInt, PetscInt>> each_once(PetscInt num_rows, PetscInt num_columns,
                                                     const VisitAll& visit_all) {
  std::vector<std::size_t> end(static_cast<std::size_t>(num_rows) + 1, 0);
  visit_all([&](PetscInt row, PetscInt) { ++end[static_cast<std::size_t>(row) + 1]; });
  std::partial_sum(end.begin(), end.end(), end.begin());
  std::vector<PetscInt> columns(end.back());
  visit_all([&](PetscInt row, PetscInt column) { columns[end[row]++] = column; });
  std::vector<std::pair<PetscInt, PetscInt>> pairs;
  std::vector<PetscInt> last_row(static_cast<std::size_t>(num_columns), -1);
  std::size_t place = 0;
  for (PetscInt row = 0; row < num_rows; ++row) {
    const std::size_t first = pairs.size();
    for (; place < end[row]; ++place) {
      if (std::exchange(last_row[columns[place]], row) != row) pairs.emplace_back(row, columns[place]);
    }
    std::ranges::sort(std::span(pairs).subspan(first));
  }
  return pairs;
}

}  // namespace

PairAssembly::PairAssembly(const NodeLayout& layout, std::vector<const PairCoupling*> couplings,
                           const std::vector<char>& prescribed)
    : layout_(layout), prescribed_(prescribed.begin(), prescribed.end()) {
  for (const PairCoupling* coupling : couplings) {
    on_path_.push_back({*coupling, {}, {}, {}, {}});
    frozen_.push_back({*coupling, {}, {}, {}, {}});
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
  for (std::vector<Pursuit>* all : {&on_path_, &frozen_}) {
    for (Pursuit& pursuit : *all) pursuit.fitted.clear();
  }
  far_.emplace(layout_, std::vector<PetscInt>{});
  pattern_.reset();
  elimination_.reset();
  has_new_far_nodes_ = is_fitted_ = false;
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
    has_new_far_nodes_ = true;
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

std::vector<PatchPair> PairAssembly::new_pairs(const Pursuit& pursuit) {
  const NearPatches& near = pursuit.near;
  std::vector<PatchPair> found;
  auto known = pursuit.fitted.begin();
  for (const PatchPair& pair : near.pairs) {
    const KeyPair keys{near.patches.keys[pair.first], near.patches.keys[pair.second]};
    while (known != pursuit.fitted.end() && *known < keys) ++known;
    if (known == pursuit.fitted.end() || *known != keys) found.push_back(pair);
  }
  return found;
}

void PairAssembly::note_fitted(Pursuit& pursuit, std::span<const PatchPair> pairs) {
  const auto middle = static_cast<std::ptrdiff_t>(pursuit.fitted.size());
  for (const PatchPair& pair : pairs) {
    pursuit.fitted.emplace_back(pursuit.near.patches.keys[pair.first], pursuit.near.patches.keys[pair.second]);
  }
  std::ranges::inplace_merge(pursuit.fitted, pursuit.fitted.begin() + middle);
}

bool PairAssembly::fit() {
  if (is_fitted_) return false;
  is_fitted_ = true;
  const auto eliminate = [&](const std::vector<double>& flags) {
    elimination_.emplace(layout_, *pattern_, std::vector<char>(flags.begin(), flags.end()));
  };
  if (!pattern_) {
    pattern_.emplace(layout_);
    eliminate(prescribed_);
  }
  const auto is_known = [&](PetscInt row, PetscInt column) { return pattern_->contains(row, column); };
  bool contains_all = !has_new_far_nodes_;
  std::vector<std::pair<Pursuit*, std::vector<PatchPair>>> fresh;
  for (std::vector<Pursuit>* all : {&on_path_, &frozen_}) {
    for (Pursuit& pursuit : *all) {
      if (!contains_all) break;
      fresh.emplace_back(&pursuit, new_pairs(pursuit));
      contains_all = all_coupled_nodes(pursuit.near, pursuit.coupling, fresh.back().second, is_known);
    }
  }
  if (!any_rank(layout_.comm, !contains_all)) {
    for (auto& [pursuit, pairs] : fresh) note_fitted(*pursuit, pairs);
    return false;
  }
  has_new_far_nodes_ = false;
  const auto visit_all = [&](const auto& visit) {
    const auto always = [&](PetscInt row, PetscInt column) {
      visit(row, column);
      return true;
    };
    for (const std::vector<Pursuit>* all : {&on_path_, &frozen_}) {
      for (const Pursuit& pursuit : *all) {
        (void)all_coupled_nodes(pursuit.near, pursuit.coupling, pursuit.near.pairs, always);
      }
    }
  };
  const auto num_columns = layout_.num_local_nodes + static_cast<PetscInt>(num_far_nodes());
  pattern_.emplace(layout_, FarCouplings{far_->globals(), each_once(layout_.num_owned_nodes, num_columns, visit_all)});
  for (std::vector<Pursuit>* all : {&on_path_, &frozen_}) {
    for (Pursuit& pursuit : *all) {
      pursuit.fitted.clear();
      note_fitted(pursuit, pursuit.near.pairs);
    }
  }
  std::vector<double> flags;
  far_->extend(prescribed_, flags);
  eliminate(flags);
  return true;
}

}  // namespace pliant
