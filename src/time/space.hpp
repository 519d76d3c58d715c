/// Configuration spaces that are not vector spaces.
#pragma once

#include "petsc/handle.hpp"

namespace pliant {

/// All formulas of the time layer are linear in coordinates. On a vector space these are q itself: there is no space
/// object, and no cost. On another space they are taken around the start q_n of the step, xi = difference(q_n, q): a
/// Runge-Kutta method or a BDF is applied in a chart of that space, so that it keeps its order.
///
/// Velocities are a vector space (of a group: its Lie algebra) and need no chart. Coordinates have the layout of
/// velocities; configurations may have another. Source: Hairer, Lubich & Wanner, Geometric Numerical Integration, IV.5
/// and IV.8. Results may not alias arguments. All methods are collective.
class ConfigurationSpace {
 public:
  virtual ~ConfigurationSpace() = default;

  /// xi = the coordinates of b around a: retract(a, xi) = b.
  virtual void difference(Vec a, Vec b, Vec xi) const = 0;
  /// b = a (+) xi.
  virtual void retract(Vec a, Vec xi, Vec b) const = 0;
  /// v = the velocity at a (+) xi of a motion whose coordinates around a have the rate xi_dot; v = xi_dot at xi = 0.
  virtual void velocity(Vec xi, Vec xi_dot, Vec v) const = 0;
};

}  // namespace pliant
