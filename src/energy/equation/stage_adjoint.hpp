/// The transposed derivatives of a stage by what it depends on, for adjoints: not for solvers.
#pragma once

#include "energy/equation/stage_terms.hpp"

#include <span>
#include <string>
#include <vector>

namespace pliant {

/// Where the slopes of a stage are added; `z0` may be nullptr if there are no internal variables.
struct SlopeVectors {
  Vec q = nullptr;
  Vec q0 = nullptr;
  Vec v0 = nullptr;
  Vec z0 = nullptr;
};

/// A view of terms, in the stage that they were begun with. Multipliers of the residual are zero on prescribed entries;
/// those of internal variables are nullptr if there are none, and are complete on the ghost cells of each rank, as
/// internal variables are. All methods are collective.
class StageAdjoint {
 public:
  explicit StageAdjoint(StageTerms& terms) : terms_(terms) {}

  /// Names of the terms that have no adjoint, each once. Not collective.
  std::vector<std::string> missing() const;
  /// Whether the Hessian is not the derivative of all forces. Not collective.
  bool has_rest() const;
  /// EnergyTerm::pull_back of all terms.
  void pull_back(Vec q, Vec residual, Vec internal, const SlopeVectors& slopes);
  /// EnergyTerm::pull_back_completion of all terms; r may be the vector of other slopes, to which it is added.
  void pull_back_completion(Vec q, Vec z, Vec r);
  /// r += EnergyTerm::add_transposed_rest of all terms.
  void add_transposed_rest(Vec q, Vec d, Vec r);
  /// works += EnergyTerm::add_cell_works of all terms.
  void add_cell_works(Vec q, Vec d, std::span<double> works);

 private:
  void add_owned(std::span<const double> rows, Vec r) const;

  StageTerms& terms_;
};

}  // namespace pliant
