/// The terms of a potential with the stage that they are evaluated in.
#pragma once

#include "energy/equation/stage_arrays.hpp"
#include "energy/function_of_sum.hpp"

#include <optional>
#include <span>
#include <vector>

namespace pliant {

/// A list of terms, and for each of them the stage as it sees it: with its internal variables, the sum over all ranks
/// that it is a function of, and the patches near one another that it couples. Not collective unless a method says so.
class StageTerms {
 public:
  /// `prescribed`: one flag per local entry. The references and terms outlive the object. Collective.
  StageTerms(const NodeLayout& layout, std::vector<const EnergyTerm*> terms, const std::vector<char>& prescribed);

  const NodeLayout& layout() const { return layout_; }
  std::span<const EnergyTerm* const> all() const { return terms_; }
  std::size_t size() const { return terms_.size(); }
  const EnergyTerm& operator[](std::size_t k) const { return *terms_[k]; }
  /// Indices of the terms that are functions of a sum over all ranks, and of those that couple pairs.
  std::span<const std::size_t> functions_of_sum() const { return functions_of_sum_; }
  std::span<const std::size_t> pair_terms() const { return pair_terms_; }
  const FunctionOfSum& function_of_sum(std::size_t k) const;

  /// The stage that all following calls refer to. Collective.
  void begin(const StagePoint& stage);
  StageArrays& arrays() { return arrays_; }
  const StageArrays& arrays() const { return arrays_; }
  /// The entries of q as terms see them, after the sums over all ranks at q have been computed. Collective.
  std::span<const double> at(Vec q);
  /// The same for a configuration that does not belong to a stage. Collective.
  std::span<const double> at_without_stage(Vec q);
  /// The stage as the k-th term sees it, with the sums at the last configuration. Valid until the next call.
  const LocalStage& stage_of(std::size_t k);
  /// The sum that the k-th term is a function of, at the last configuration.
  double sum_of(std::size_t k) const { return sums_[k].total(); }
  /// The patches near one another that the k-th term couples, and those where its coefficients are frozen; nullptr if
  /// it is another kind of term.
  const NearPatches* near(std::size_t k) const;
  const NearPatches* near_frozen(std::size_t k) const;
  /// Zeros for the rows of all nodes that terms see; valid until the next call.
  std::span<double> empty_rows();

  /// Number of internal variables of all terms on this rank.
  std::size_t num_internal() const { return first_internal_.back(); }
  /// Those of the k-th term among them.
  template <class T>
  std::span<T> internal_of(std::size_t k, std::span<T> z) const {
    return z.subspan(first_internal_[k], first_internal_[k + 1] - first_internal_[k]);
  }
  /// The same; none if z is nullptr. Valid while the vector lives.
  std::span<const double> internal_of(std::size_t k, Vec z) const;

 private:
  void add_up(LocalStage stage, std::span<const double> q);

  const NodeLayout& layout_;
  std::vector<const EnergyTerm*> terms_;
  StageArrays arrays_;
  std::vector<std::size_t> functions_of_sum_, pair_terms_;
  std::vector<std::optional<std::size_t>> pairs_of_term_;  // number of its coupling in PairAssembly
  std::vector<std::size_t> first_internal_;                // of each term, and their total
  Vec z0_ = nullptr, accepted_z_ = nullptr;                // of the stage, borrowed
  std::vector<SumOverRanks> sums_;                         // of each term, at the last configuration
  std::vector<double> rows_;
};

}  // namespace pliant
