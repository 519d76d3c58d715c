/// Solutions of the equations of joints that are far away.
#pragma once

#include "energy/rigid/joint_derivative.hpp"

#include <cmath>
#include <eigen3/Eigen/Core>
#include <utility>

namespace pliant {

/// Relative to the size: equations that hold to this tolerance are solved.
inline constexpr double joint_tolerance = 1e-14;

/// How a search ended.
enum class Descent { nothing_to_do, done, failed };

/// Gauss and Newton's method for h(x) = 0 from far away: steps that do not lower |h| are shortened. Until |h| is that
/// of rounding, about `size` times the tolerance. `weights`: how willingly each unknown changes. `evaluate(x, h, G)`;
/// `moved(x, change)` is x after a change.
template <class X, class Evaluate, class Move>
Descent descend(X& x, double size, const Eigen::VectorXd& weights, const Evaluate& evaluate, const Move& moved) {
  constexpr int most_iterations = 100, most_halvings = 20;
  Eigen::VectorXd h, h_next;
  JointDerivative G, G_next;
  evaluate(x, h, G);
  for (int i = 0; i < most_iterations; ++i) {
    if (!h.allFinite()) return Descent::failed;
    if (h.size() == 0 || h.lpNorm<Eigen::Infinity>() <= joint_tolerance * size) {
      return i == 0 ? Descent::nothing_to_do : Descent::done;
    }
    const Eigen::VectorXd change = -G.smallest_change(h, weights);
    const bool is_near = h.lpNorm<Eigen::Infinity>() <= std::sqrt(joint_tolerance) * size;
    bool is_lower = false;
    for (int k = 0; k < (is_near ? 1 : most_halvings) && !is_lower; ++k) {
      X next = moved(x, std::ldexp(1.0, -k) * change);
      evaluate(next, h_next, G_next);
      is_lower = h_next.norm() < h.norm();
      if (!is_lower) continue;
      x = std::move(next);
      h.swap(h_next);
      std::swap(G, G_next);
    }
    if (is_lower) continue;
    // To rounding: nothing lowers it any more.
    if (!is_near) return Descent::failed;
    return i == 0 ? Descent::nothing_to_do : Descent::done;
  }
  return Descent::failed;
}

}  // namespace pliant
