/// The incremental potential of a stage: the sum of its terms over all ranks, with prescribed entries eliminated.
#pragma once

#include "energy/term.hpp"
#include "fem/block_matrix.hpp"
#include "fem/layout.hpp"
#include "time/stage.hpp"

#include <memory>
#include <vector>

namespace pliant {

/// Phi(q) = sum of terms(q); docs: dynamics, "Mechanics". All methods are collective and give every rank the same
/// answer, NaN and infinity included, so that no rank decides alone. Works on vectors of make_vector(layout).
class IncrementalPotential {
 public:
  /// `prescribed`: one flag per local entry. The references and terms outlive the object.
  IncrementalPotential(const NodeLayout& layout, const BlockPattern& pattern, std::vector<const EnergyTerm*> terms,
                       const std::vector<char>& prescribed);

  /// The stage that all following calls speak of.
  void begin_stage(const StagePoint& stage);

  /// Phi(q) - Phi(q0) [J]; +inf where a barrier is crossed or a number is not finite.
  double value(Vec q);
  /// r = dPhi/dq [N], zero on prescribed entries.
  void gradient(Vec q, Vec r);
  /// The same with what it takes to hold the prescribed entries: the reactions stand there.
  void gradient_with_reactions(Vec q, Vec r);
  /// A zero matrix for the Hessian, with the rigid-body modes as its near-null space.
  Handle<Mat> make_hessian() const;
  /// K = d2Phi/dq2 [N/m]; rows and columns of prescribed entries are zero but for the diagonal.
  void hessian(Vec q, Mat K, Projection projection);
  /// The largest alpha for which q + alpha d stays clear of all barriers.
  double max_step(Vec q, Vec d);
  /// Sum over the terms of the norms of their gradients on free entries [N]: the size of the forces that must balance.
  double force_scale(Vec q);
  /// Size of the rounding errors in the gradient at q [N]: |eps K_ii u_i|, with the diagonal of the last Hessian.
  double rounding_floor(Vec q) const;

  bool is_potential() const;
  const std::vector<char>& prescribed() const { return prescribed_; }
  PetscInt num_unknowns() const { return 3 * layout_.num_global_nodes; }
  MPI_Comm comm() const { return layout_.comm; }
  /// A zero vector of the unknowns.
  Handle<Vec> make_vector() const { return pliant::make_vector(layout_); }

 private:
  std::span<const double> local(Vec q, const Handle<Vec>& work);
  void clear_prescribed(std::span<double> r) const;

  const NodeLayout& layout_;
  const BlockPattern& pattern_;
  std::vector<const EnergyTerm*> terms_;
  std::vector<char> prescribed_;
  RowElimination elimination_;
  LocalStage stage_;
  // Copies with ghosts of the vectors spoken of; memory taken once.
  Handle<Vec> q_, d_, q0_, v0_, work_, diagonal_;
};

}  // namespace pliant
