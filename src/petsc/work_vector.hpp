/// Vectors for intermediate results.
#pragma once

#include "petsc/handle.hpp"

#include <functional>
#include <utility>

namespace pliant {

/// A vector that takes memory from its first use on: PETSc fills a new vector with zeros, so that one that is never
/// used costs as much as any other.
class WorkVector {
 public:
  /// What `make` refers to outlives the object.
  explicit WorkVector(std::function<Handle<Vec>()> make) : make_(std::move(make)) {}
  /// A vector of the unknowns of an equation, which outlives the object.
  template <class Equation>
  requires requires(const Equation& equation) { equation.make_vector(); }
  explicit WorkVector(const Equation& equation) : WorkVector([&equation] { return equation.make_vector(); }) {}

  /// Collective at the first use.
  Vec get() const {
    if (!vector_) vector_ = make_();
    return vector_.get();
  }
  bool is_used() const { return static_cast<bool>(vector_); }

 private:
  std::function<Handle<Vec>()> make_;
  mutable Handle<Vec> vector_;
};

}  // namespace pliant
