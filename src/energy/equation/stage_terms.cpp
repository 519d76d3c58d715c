#include "energy/equation/stage_terms.hpp"

#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"

#include <algorithm>

namespace pliant {
namespace {

/// Each once, in the order of the terms.
std::vector<const PairCoupling*> pair_couplings(std::span<const EnergyTerm* const> terms) {
  std::vector<const PairCoupling*> couplings;
  for (const EnergyTerm* term : terms) {
    const PairCoupling* pairs = pair_coupling(term->coupling());
    if (pairs != nullptr && std::ranges::find(couplings, pairs) == couplings.end()) couplings.push_back(pairs);
  }
  return couplings;
}

}  // namespace

StageTerms::StageTerms(const NodeLayout& layout, std::vector<const EnergyTerm*> terms,
                       const std::vector<char>& prescribed)
    : layout_(layout), terms_(std::move(terms)), arrays_(layout, pair_couplings(terms_), prescribed) {
  const auto couplings = pair_couplings(terms_);
  first_internal_.push_back(0);
  for (std::size_t k = 0; k < terms_.size(); ++k) {
    first_internal_.push_back(first_internal_.back() + terms_[k]->num_internal());
    const Coupling coupling = terms_[k]->coupling();
    if (pliant::function_of_sum(coupling) != nullptr) functions_of_sum_.push_back(k);
    pairs_of_term_.emplace_back();
    if (const PairCoupling* pairs = pair_coupling(coupling)) {
      pair_terms_.push_back(k);
      pairs_of_term_[k] = static_cast<std::size_t>(std::ranges::find(couplings, pairs) - couplings.begin());
    }
  }
  sums_.resize(terms_.size());
}

const FunctionOfSum& StageTerms::function_of_sum(std::size_t k) const {
  return *pliant::function_of_sum(terms_[k]->coupling());
}

void StageTerms::begin(const StagePoint& stage) {
  arrays_.begin(stage);
  z0_ = stage.z0;
  accepted_z_ = stage.accepted_z;
}

std::span<const double> StageTerms::at(Vec q) {
  const auto entries = arrays_.at(q);
  add_up(arrays_.stage(), entries);
  return entries;
}

std::span<const double> StageTerms::at_without_stage(Vec q) {
  const auto entries = arrays_.at(q);
  LocalStage here;  // a stage that starts at q
  here.q0 = entries;
  add_up(here, entries);
  return entries;
}

void StageTerms::add_up(LocalStage stage, std::span<const double> q) {
  if (functions_of_sum_.empty()) return;
  std::vector<double> parts;
  for (const std::size_t k : functions_of_sum_) {
    stage.near = near(k);
    const SumOverRanks part = function_of_sum(k).part(stage, q);
    parts.insert(parts.end(), {part.start, part.change});
  }
  sum_in_place(layout_.comm, parts);
  for (std::size_t i = 0; i < functions_of_sum_.size(); ++i) {
    sums_[functions_of_sum_[i]] = {parts[2 * i], parts[2 * i + 1]};
  }
}

const LocalStage& StageTerms::stage_of(std::size_t k) {
  LocalStage& stage = arrays_.stage();
  stage.sum = sums_[k];
  stage.near = near(k);
  stage.near_frozen = near_frozen(k);
  stage.z0 = internal_of(k, z0_);
  stage.accepted_z = internal_of(k, accepted_z_);
  return stage;
}

const NearPatches* StageTerms::near(std::size_t k) const {
  return pairs_of_term_[k] ? &arrays_.pairs()->near(*pairs_of_term_[k]) : nullptr;
}

const NearPatches* StageTerms::near_frozen(std::size_t k) const {
  return pairs_of_term_[k] ? &arrays_.pairs()->near_frozen(*pairs_of_term_[k]) : nullptr;
}

std::span<double> StageTerms::empty_rows() {
  rows_.assign(3 * arrays_.num_nodes(), 0.0);
  return rows_;
}

std::span<const double> StageTerms::internal_of(std::size_t k, Vec z) const {
  if (z == nullptr) return {};
  const ConstArrayView values(z);  // the memory stays where it is while the vector lives
  return internal_of(k, values.span());
}

}  // namespace pliant
