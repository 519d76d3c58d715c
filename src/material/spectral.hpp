/// Isotropic laws written in the principal stretches: the stretches and directions of F = I + H, accurate to the last
/// digits when H is small, also if stretches are equal or the body is flat or inverted, and the tangent of an energy of
/// the stretches.
///
///   F = sum_i l_i r_i n_i^T,  l_1 >= l_2 >= |l_3|
/// where (n_i) and (r_i) are right-handed frames. l_3 thus has the sign of J, and R = sum_i r_i n_i^T is the rotation
/// nearest to F, which is unique if l_2 + l_3 > 0. Source: Irving, Teran & Fedkiw, "Invertible finite elements for
/// robust simulation of large deformation", Symp. Computer Animation (2004).
#pragma once

#include "base/vector3.hpp"
#include "base/vector_math.hpp"
#include "material/kinematics.hpp"
#include "material/law.hpp"

#include <array>
#include <limits>

namespace pliant {

/// Eigenvalues of a symmetric tensor in descending order, to eps of the largest, and the eigenvectors as columns.
template <class T>
struct EigenDecomposition {
  std::array<T, 3> values;
  Tensor3<T> vectors;
};

/// One Jacobi rotation, which makes A(p, q) zero and updates V.
template <int p, int q, class T>
PLIANT_INLINE void jacobi_rotation(Tensor3<T>& A, Tensor3<T>& V) {
  constexpr int r = 3 - p - q;
  const T off = A(p, q), d = A(q, q) - A(p, p), b = 2.0 * off;
  const T size = sqrt(d * d + b * b) + select(d < 0.0, T(-d), d);
  const auto turns = size > 0.0;
  const T tan = select(turns, select(d < 0.0, T(-b), b), T(0.0)) / select(turns, size, T(1.0));
  const T c = 1.0 / sqrt(1.0 + tan * tan), s = tan * c;
  A(p, p) -= tan * off;
  A(q, q) += tan * off;
  A(p, q) = A(q, p) = T(0.0);
  const T rp = A(r, p), rq = A(r, q);
  A(r, p) = A(p, r) = c * rp - s * rq;
  A(r, q) = A(q, r) = s * rp + c * rq;
  unroll<3>([&](auto i) __attribute__((always_inline)) {
    const T vp = V(i, p), vq = V(i, q);
    V(i, p) = c * vp - s * vq;
    V(i, q) = s * vp + c * vq;
  });
}

template <int p, int q, class T>
PLIANT_INLINE void put_in_descending_order(Tensor3<T>& A, Tensor3<T>& V) {
  const auto swap = A(p, p) < A(q, q);
  const T a = A(p, p), b = A(q, q);
  A(p, p) = select(swap, b, a);
  A(q, q) = select(swap, a, b);
  unroll<3>([&](auto i) __attribute__((always_inline)) {
    const T vp = V(i, p), vq = V(i, q);
    V(i, p) = select(swap, vq, vp);
    V(i, q) = select(swap, vp, vq);
  });
}

/// Computed by the cyclic Jacobi method: no branches on the entries, and the same accuracy if eigenvalues are equal.
/// Source: Golub & Van Loan, Matrix Computations (4th ed. 2013), section 8.5.
template <class T>
PLIANT_INLINE EigenDecomposition<T> eigen_decomposition(Tensor3<T> A) {
  constexpr double negligible = 0.25 * std::numeric_limits<double>::epsilon();
  constexpr int most_sweeps = 8;  // it converges quadratically: four or five
  Tensor3<T> V = identity<T>();
  for (int sweep = 0; sweep < most_sweeps; ++sweep) {
    const T off = A(0, 1) * A(0, 1) + A(0, 2) * A(0, 2) + A(1, 2) * A(1, 2);
    if (!any_of(off > negligible * negligible * dot(A, A))) break;
    jacobi_rotation<0, 1>(A, V);
    jacobi_rotation<0, 2>(A, V);
    jacobi_rotation<1, 2>(A, V);
  }
  put_in_descending_order<0, 1>(A, V);
  put_in_descending_order<0, 2>(A, V);
  put_in_descending_order<1, 2>(A, V);
  return {{A(0, 0), A(1, 1), A(2, 2)}, V};
}

template <class T>
struct PrincipalStretches {
  Tensor3<T> n, r;          ///< columns: n_i, r_i
  std::array<T, 3> strain;  ///< l_i - 1, to eps of the largest
  std::array<T, 3> l;

  /// sum_i values_i r_i n_i^T.
  PLIANT_INLINE Tensor3<T> assemble(const std::array<T, 3>& values) const {
    return make_tensor([&](int i, int J) -> T {
      return (values[0] * r(i, 0)) * n(J, 0) + (values[1] * r(i, 1)) * n(J, 1) + (values[2] * r(i, 2)) * n(J, 2);
    });
  }
};

/// The unit vector along v; `otherwise` if |v|^2 <= floor.
template <class T>
PLIANT_INLINE std::array<T, 3> unit_vector(const std::array<T, 3>& v, const T& floor,
                                           const std::array<T, 3>& otherwise) {
  const T square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
  const auto good = square > floor;
  const T scale = 1.0 / sqrt(select(good, square, T(1.0)));
  return {select(good, T(scale * v[0]), otherwise[0]), select(good, T(scale * v[1]), otherwise[1]),
          select(good, T(scale * v[2]), otherwise[2])};
}

/// A unit vector normal to the unit vector r.
template <class T>
PLIANT_INLINE std::array<T, 3> any_normal(const std::array<T, 3>& r) {
  // e_x or e_y, whichever is less parallel to r.
  const auto x = r[0] * r[0] < r[1] * r[1];
  const std::array<T, 3> axis{select(x, T(1.0), T(0.0)), select(x, T(0.0), T(1.0)), T(0.0)};
  return unit_vector(cross(r, axis), T(0.0), axis);
}

template <class T>
PLIANT_INLINE PrincipalStretches<T> principal_stretches(const Tensor3<T>& H) {
  // C = I + 2 E. Stretches along thin directions are taken from F instead, where they are not squared.
  const EigenDecomposition<T> E = eigen_decomposition(green_lagrange(H));
  const Tensor3<T> F = add_to_diagonal(H, 1.0);
  const auto column = [](const Tensor3<T>& A, int i) -> std::array<T, 3> { return {A(0, i), A(1, i), A(2, i)}; };
  const auto inner = [](const std::array<T, 3>& a, const std::array<T, 3>& b) -> T {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  };
  const auto n1 = column(E.vectors, 0), n2 = column(E.vectors, 1), n3 = cross(n1, n2);
  Tensor3<T> n = E.vectors;
  unroll<3>([&](auto i) __attribute__((always_inline)) { n(i, 2) = n3[i]; });
  const Tensor3<T> Fn = matmul(F, n);
  const auto f1 = column(Fn, 0), f2 = column(Fn, 1), f3 = column(Fn, 2);
  const auto r1 = unit_vector(f1, T(0.0), n1);
  // If the second stretch is negligible relative to the first, the body is a thread, and any frame around it is valid.
  constexpr double thread = 1e-14;
  const T along = inner(r1, f2);
  const std::array<T, 3> across{f2[0] - along * r1[0], f2[1] - along * r1[1], f2[2] - along * r1[2]};
  const auto r2 = unit_vector(across, T(thread * thread * inner(f1, f1)), any_normal(r1));
  const auto r3 = cross(r1, r2);
  const Tensor3<T> r{{r1[0], r2[0], r3[0], r1[1], r2[1], r3[1], r1[2], r2[2], r3[2]}};
  const std::array<T, 3> from_F{inner(r1, f1), inner(r2, f2), inner(r3, f3)};
  PrincipalStretches<T> result{n, r, {}, {}};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto thick = from_F[i] > 0.5;
    const T strain = 2.0 * E.values[i] / (1.0 + select(thick, from_F[i], T(1.0)));  // l - 1 = (l^2 - 1) / (l + 1)
    result.strain[i] = select(thick, strain, T(from_F[i] - 1.0));
    result.l[i] = 1.0 + result.strain[i];
  }
  return result;
}

/// P and dP of an energy of the stretches, from its derivatives. In the frames (r_i), (n_i), with B = r^T dH n,
///   dP_ii = sum_j normal_ij B_jj
///   dP_ij = shear_k (B_ij + B_ji)/2 + twist_k (B_ij - B_ji)/2,   i, j, k different
///   normal_ij = d^2 psi / dl_i dl_j,  shear_k = (P_i - P_j)/(l_i - l_j),  twist_k = (P_i + P_j)/(l_i + l_j).
/// Source: Smith, de Goes & Kim, "Analytic eigensystems for isotropic distortion energies", ACM Trans. Graph. 38
/// (2019).
template <class T>
struct SpectralLinearization {
  PrincipalStretches<T> at;
  Tensor3<T> normal;              ///< [Pa]
  std::array<T, 3> shear, twist;  ///< [Pa]
  Tensor3<T> P;                   ///< [Pa]

  PLIANT_INLINE Tensor3<T> operator()(const Tensor3<T>& dH) const {
    const Tensor3<T> B = matmul(transpose(at.r), matmul(dH, at.n));
    Tensor3<T> Q;
    unroll<3>([&](auto k) __attribute__((always_inline)) {
      constexpr int i = (k + 1) % 3, j = (k + 2) % 3;
      Q(k, k) = normal(k, 0) * B(0, 0) + normal(k, 1) * B(1, 1) + normal(k, 2) * B(2, 2);
      const T sum = 0.5 * shear[k] * (B(i, j) + B(j, i)), difference = 0.5 * twist[k] * (B(i, j) - B(j, i));
      Q(i, j) = sum + difference;
      Q(j, i) = sum - difference;
    });
    return matmul(matmul(at.r, Q), transpose(at.n));
  }

  /// The tangent as a sum of nine products left_m (x) right_m.
  PLIANT_INLINE Tangent<T> tangent() const {
    std::array<Tensor3<T>, 9> left, right;
    const auto dyad = [&](int i, int j) __attribute__((always_inline)) {
      return make_tensor([&](int a, int B) -> T { return at.r(a, i) * at.n(B, j); });
    };
    for (int i = 0; i < 3; ++i) left[static_cast<std::size_t>(i)] = dyad(i, i);
    unroll<3>([&](auto k) __attribute__((always_inline)) {
      constexpr int i = (k + 1) % 3, j = (k + 2) % 3;
      right[k] = normal(k, 0) * left[0] + normal(k, 1) * left[1] + normal(k, 2) * left[2];
      const Tensor3<T> X = left[3 + k] = dyad(i, j);
      const Tensor3<T> Y = left[6 + k] = dyad(j, i);
      const T same = 0.5 * (shear[k] + twist[k]), other = 0.5 * (shear[k] - twist[k]);
      right[3 + k] = same * X + other * Y;
      right[6 + k] = other * X + same * Y;
    });
    return make_symmetric_tangent<T>([&](int p, int q) -> T {
      const auto a = static_cast<std::size_t>(p), b = static_cast<std::size_t>(q);
      T value = left[0].a[a] * right[0].a[b];
      for (std::size_t m = 1; m < 9; ++m) value += left[m].a[a] * right[m].a[b];
      return value;
    });
  }
};

}  // namespace pliant
