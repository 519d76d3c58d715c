/// The angle between two triangles that share an edge, and what the angles around a triangle say about its curvature.
#pragma once

#include "base/second_order.hpp"
#include "base/vector3.hpp"

#include <array>
#include <span>

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

/// Not inlined, so that angles at rest and those of an unmoved layer are equal to the last bit.
template <int order>
[[gnu::noinline]] Differentiated<9, order> differentiated_angle(const HingeVectors& at) {
  using Number = Differentiated<9, order>;
  std::array<Vector3<Number>, 3> x;
  for (std::size_t i = 0; i < 9; ++i) x[i / 3][i % 3] = Number::variable(at[i / 3][i % 3], i);
  return hinge_angle(x[0], x[1], x[2]);
}

/// A triangle and the far corners of its neighbours: across the edge from corner k to k + 1 lies `others[k]`.
struct HingePatch {
  std::array<Vector3<double>, 3> corners{}, others{};
  std::array<bool, 3> has_other{};
};

/// The matrix M of the energy 1/2 sum M_ij d_i d_j of a plate in the changes d of the angles at the edges of a
/// triangle; zero in rows of edges without a neighbour. Neighbours are unfolded into the plane of the triangle. A
/// deflection that is quadratic there has the angles B kappa, kappa its curvature (xx, yy, 2 xy); M gives it the energy
///
///     A/2 kappa.C kappa,   C = D [1 nu 0; nu 1 0; 0 0 (1 - nu)/2],    M = A (B C^-1 B^T)^-1
///
/// of the triangle's area A: exact for constant curvature on any mesh, and, where neighbours are missing, the least
/// energy of all curvatures with the angles that there are (free edges). `rigidity`: D = E h^3 / (12 (1 - nu^2)) [N m].
std::array<double, 9> hinge_matrix(const HingePatch& patch, double rigidity, double poissons_ratio);

}  // namespace pliant
