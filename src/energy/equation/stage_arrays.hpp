/// A stage as terms see it: the vectors of a stage with the nodes of other ranks that this rank needs.
#pragma once

#include "energy/pairs/pair_assembly.hpp"
#include "energy/term.hpp"
#include "petsc/work_vector.hpp"
#include "time/stage.hpp"

#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace pliant {

/// Copies of the vectors of a stage with the ghosts of cells and, where terms couple pairs, the far nodes of these. All
/// spans that it gives, those of the stage included, are of one length; they hold until the next call.
class StageArrays {
 public:
  /// `couplings`: of the terms that couple pairs. The references outlive the object.
  StageArrays(const NodeLayout& layout, std::vector<const PairCoupling*> couplings,
              const std::vector<char>& prescribed);

  /// The stage that all following calls speak of. Collective.
  void begin(const StagePoint& stage);
  LocalStage& stage() { return stage_; }
  /// Its vectors, with the ghosts of cells.
  Vec q0() const { return q0_.ghosted.get(); }
  Vec v0() const { return v0_.ghosted.get(); }
  Vec accepted() const { return accepted_.ghosted.get(); }

  /// Sets LocalStage::frozen to q. Collective.
  void freeze(Vec q) { stage_.frozen = copied(q, frozen_); }
  /// Sets LocalStage::previous to q, or to none. Collective.
  void extrapolate_from(Vec q) { stage_.previous = q != nullptr ? copied(q, previous_) : std::span<const double>{}; }

  /// The entries of q, with pairs as they are near there. Collective.
  std::span<const double> at(Vec q);
  /// Those of q and d, with all pairs that come near between q and q + end d. Its end is 1 unless d is so long that too
  /// many patches would meet (PairAssembly::searchable_part); beyond it pairs may be missed. Collective.
  Path along(Vec q, Vec d);
  /// The entries of another vector at the configuration of the last call of `at`. Collective.
  std::span<const double> beside(Vec v) { return copied(v, d_); }
  /// Makes the pairs those at LocalStage::accepted. Collective.
  void return_to_accepted();

  /// The number of nodes that all spans have.
  std::size_t num_nodes() const;
  /// nullptr where no term couples pairs.
  PairAssembly* pairs() { return pairs_.get(); }
  const PairAssembly* pairs() const { return pairs_.get(); }

 private:
  struct Copy {
    explicit Copy(const NodeLayout& layout) : ghosted([&layout] { return make_vector(layout); }) {}
    WorkVector ghosted;
    std::vector<double> extended;  // with far nodes; empty if there are no pairs
  };
  std::span<const double> copied(Vec v, Copy& copy);
  /// Brings pairs to the path, whose arrays are copies of q and d, and to where coefficients are frozen; and all copies
  /// in use to the far nodes.
  void follow_pairs(Path& path, Copy& of_q);

  const NodeLayout& layout_;
  std::vector<const PairCoupling*> couplings_;
  std::unique_ptr<PairAssembly> pairs_;
  LocalStage stage_;
  Copy q_{layout_}, d_{layout_}, q0_{layout_}, v0_{layout_}, accepted_{layout_}, previous_{layout_}, frozen_{layout_};
};

}  // namespace pliant
