/// The angle between two triangles that share an edge.
///
/// Source: the angle as a measure of bending of discrete surfaces: Grinspun, Hirani, Desbrun & Schröder, Discrete
/// shells, SCA 2003.
#pragma once

#include "base/second_order.hpp"
#include "base/vector3.hpp"

#include <array>

namespace pliant {

/// The angle by which a triangle (a, b, c) and its neighbour (b, a, o) are folded about their edge from a to b: 0 where
/// they are flat, positive where o leaves the plane to the side of (b - a) x (c - a); in (-pi, pi).
///
///     theta = atan2( |e| v.n, n.(v x e) ),   e = b - a, u = c - a, v = o - a, n = e x u
template <class T>
T hinge_angle(const Vector3<T>& e, const Vector3<T>& u, const Vector3<T>& v) {
  using std::atan2;
  using std::sqrt;
  const Vector3<T> n = cross(e, u);
  return atan2(sqrt(dot(e, e)) * dot(v, n), dot(n, cross(v, e)));
}

/// e, u, v of a hinge as variables 0 to 8.
using HingeVectors = std::array<Vector3<double>, 3>;

template <int order>
Differentiated<9, order> differentiated_angle(const HingeVectors& at) {
  using Number = Differentiated<9, order>;
  std::array<Vector3<Number>, 3> x;
  for (std::size_t i = 0; i < 9; ++i) x[i / 3][i % 3] = Number::variable(at[i / 3][i % 3], i);
  return hinge_angle(x[0], x[1], x[2]);
}

/// d(e, u, v)/d(a, b, c, o), 9 rows of 12. `mirror`: a unit vector m where o is the image of c in the plane through a
/// across m, v = u - 2 (u.m) m; the columns of o are then zero.
using HingeMap = std::array<double, 108>;
HingeMap hinge_map(const Vector3<double>* mirror);

}  // namespace pliant
