/// One part of y = (q, v, z) in the stage algebra of a method (time/method.hpp).
#pragma once

#include "petsc/handle.hpp"
#include "time/method.hpp"

#include <span>
#include <vector>

namespace pliant {

/// The vectors Y_i0, Y_i, y_{n+1} of one part of y and the sums that form them; the stepper decides which stages there
/// are and solves them. Memory is allocated once. All methods are collective.
class StageVariable {
 public:
  StageVariable() = default;
  /// Vectors are made like `layout`.
  StageVariable(const Method& method, Vec layout);

  /// y* = y_n + sum_{r>=2} alpha_r (y_{n+1-r} - y_n), the past states newest first; overwrites Y_i.
  void set_base(std::span<const Vec> past, std::span<const double> alpha);
  /// Y_i0 = y* + sum_{j<i} At_ij (Y_j - y*).
  void start_stage(std::span<const double> At_i);
  /// Keeps Y_i - y* of a stage, counted from 0, if a later one or the end needs it.
  void end_stage(std::size_t i);
  /// end() = y_{n+1} - bt_s Y_s, before the last stage s; not needed for a stiffly accurate method.
  void start_last_stage(std::span<const double> bt);
  /// y_{n+1} = y* + sum_i bt_i (Y_i - y*); for a stiffly accurate method it is Y_s, already in place.
  void complete_step(std::span<const double> bt);

  /// x = sum_i d_i (Y_i - y*), after the step's completion.
  void combine_increments(std::span<const double> d, Vec x) const;

  Vec start() const { return start_.get(); }  ///< Y_i0
  Vec stage() const { return stage_.get(); }  ///< Y_i
  Vec end() const { return end_.get(); }      ///< y_{n+1}; the same vector as Y_s if the method is stiffly accurate

 private:
  Handle<Vec> base_, start_, stage_, end_;
  std::vector<Handle<Vec>> increments_;  // Y_i - y*
  std::vector<Vec> borrowed_;            // the same, as PETSc wants them
};

}  // namespace pliant
