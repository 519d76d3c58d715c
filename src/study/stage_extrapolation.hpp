/// Solutions of the stages of a motion, continued in time.
#pragma once

#include "petsc/handle.hpp"

#include <array>
#include <cstddef>
#include <vector>

namespace pliant {

/// A guess of the next solution: the polynomial through the last ones, of the degree that would have guessed the last
/// solution best. All methods are collective.
class StageExtrapolation {
 public:
  /// Vectors are made like `like`.
  explicit StageExtrapolation(Vec like);

  /// Sets x to a guess of the solution at this place (a time or a load factor). Returns false, with x = 0, if there is
  /// none that is worth having.
  bool guess(double place, Vec x) const;
  /// The solution at this place.
  void take(double place, Vec solution);

 private:
  static constexpr std::size_t most = 6;  // solutions that are kept
  struct Known {
    double place;
    Handle<Vec> solution;
  };
  /// x = the polynomial through the last `count` solutions, at this place.
  void extrapolate(std::size_t count, double place, Vec x) const;

  std::vector<Known> known_;  // newest first
  std::size_t count_ = 0;     // of the polynomial that guessed best; 0: none did
  Handle<Vec> trial_;
};

}  // namespace pliant
