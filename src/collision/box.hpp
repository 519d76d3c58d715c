/// Boxes of single precision around points of double precision, rounded outwards: what they hold they never lose.
#pragma once

#include "base/vector3.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace pliant {

/// A float at most (at least) x, and at most 2 units in the last place away. For x of any size, infinities included.
inline float rounded_down(double x) {
  constexpr double relative = 1.2e-7, absolute = 1.2e-38;  // of the float's digits, and its least normal number
  constexpr double largest = std::numeric_limits<double>::max();
  return static_cast<float>(std::clamp(x - relative * std::min(std::abs(x), largest) - absolute, -largest,
                                       static_cast<double>(std::numeric_limits<float>::max())));
}
inline float rounded_up(double x) {
  return -rounded_down(-x);
}

/// From low to high, faces included. A box of nothing has low = +infinity, high = -infinity: it overlaps none.
struct Box {
  std::array<float, 3> low{std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity(),
                           std::numeric_limits<float>::infinity()};
  std::array<float, 3> high{-std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(),
                            -std::numeric_limits<float>::infinity()};

  void include(const Box& other) {
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], other.low[k]);
      high[k] = std::max(high[k], other.high[k]);
    }
  }
  bool overlaps(const Box& other) const {
    bool is_apart = false;
    for (int k = 0; k < 3; ++k) is_apart = is_apart || low[k] > other.high[k] || other.low[k] > high[k];
    return !is_apart;
  }
  /// False for a point with a NaN.
  bool contains(const Vector3<double>& x) const {
    bool is_inside = true;
    for (int k = 0; k < 3; ++k) is_inside = is_inside && double{low[k]} <= x[k] && x[k] <= double{high[k]};
    return is_inside;
  }
  /// The box whose sides are `margin` [m] further out.
  Box grown(double margin) const {
    Box box;
    for (int k = 0; k < 3; ++k) {
      box.low[k] = rounded_down(double{low[k]} - margin);
      box.high[k] = rounded_up(double{high[k]} + margin);
    }
    return box;
  }
};

/// The box around points (at least one), `margin` [m] further out on all sides.
template <class... Points>
Box box_of(double margin, const Vector3<double>& first, const Points&... others) {
  Box box;
  for (int k = 0; k < 3; ++k) {
    box.low[k] = rounded_down(std::min({first[k], others[k]...}) - margin);
    box.high[k] = rounded_up(std::max({first[k], others[k]...}) + margin);
  }
  return box;
}

}  // namespace pliant
