/// The transpose of the stage algebra of a method (time/stage_variable.hpp), for adjoints.
#pragma once

#include "petsc/handle.hpp"
#include "time/method.hpp"

#include <cstddef>
#include <span>
#include <vector>

namespace pliant {

/// Derivatives of a number J by the vectors y*, Y_i of one part of y, in a step that is followed backwards
/// (docs/theory.md, "The adjoint of a run"). From dJ/dy_{n+1} the sums
///
///     y_{n+1} = y* + sum_i bt_i (Y_i - y*),   Y_i0 = y* + sum_{j<i} At_ij (Y_j - y*)
///
/// give those by y* and Y_i. Memory is taken once. All methods are collective.
class TransposedVariable {
 public:
  /// For methods with at most `num_stages` stages; vectors are made like `like`.
  TransposedVariable(std::size_t num_stages, Vec like);

  /// Begins with dJ/dy_{n+1}.
  void begin(const Method& method, Vec end);
  /// dJ/dY_i so far; it is complete, but for what its own stage adds, when all later stages have been started.
  Vec stage(std::size_t i) const { return stages_[i].get(); }
  /// Adds dJ/dY_i0 of a stage, from the last to the first.
  void start_stage(const Method& method, std::size_t i, Vec start);
  /// dJ/dy*, after the first stage.
  Vec base() const { return base_.get(); }

 private:
  Handle<Vec> base_;
  std::vector<Handle<Vec>> stages_;
};

}  // namespace pliant
