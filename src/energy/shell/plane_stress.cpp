#include "energy/shell/plane_stress.hpp"

#include "base/vector3.hpp"
#include "energy/volume/body_cells.hpp"

#include <limits>

namespace pliant {
namespace {

using PackVector = Vector3<Pack>;

PLIANT_INLINE PackVector row(const LayerAxes& axes, int a) {
  return {axes(a, 0), axes(a, 1), axes(a, 2)};
}

/// h_1 (x) t_1 + h_2 (x) t_2 + w (x) N.
PLIANT_INLINE Tensor3<Pack> gradient_of(const LayerAxes& axes, const LayerColumns& h, const PackVector& w) {
  return make_tensor(
      [&](int i, int J) -> Pack { return h[0][i] * axes(0, J) + h[1][i] * axes(1, J) + w[i] * axes(2, J); });
}

/// P e_a.
PLIANT_INLINE PackVector column(const Tensor3<Pack>& P, const LayerAxes& axes, int a) {
  return matvec(P, row(axes, a));
}

/// d - N of a layer whose volume does not change: d = m / m.m with m = f_1 x f_2 = N + c.
PackVector without_change_of_volume(const LayerAxes& axes, const LayerColumns& h) {
  const PackVector t1 = row(axes, 0), t2 = row(axes, 1), N = row(axes, 2);
  const PackVector c = cross(h[0], t2) + (cross(t1, h[1]) + cross(h[0], h[1]));
  const Pack excess = 2.0 * dot(N, c) + dot(c, c);  // m.m - 1
  return (1.0 / (1.0 + excess)) * (c - excess * N);
}

/// A_iJkL N_J N_L.
Tensor3<Pack> across(const Tangent<Pack>& A, const PackVector& N) {
  return make_tensor([&](int i, int k) -> Pack {
    Pack sum = 0.0;
    for (int J = 0; J < 3; ++J) {
      const Pack* entry = A.data() + 9 * (3 * i + J) + 3 * k;
      sum += N[J] * (entry[0] * N[0] + entry[1] * N[1] + entry[2] * N[2]);
    }
    return sum;
  });
}

/// K^-1 of a symmetric matrix.
Tensor3<Pack> inverse(const Tensor3<Pack>& K) {
  return (1.0 / det(K)) * transpose(cofactor(K));
}

/// |E|^2 in the layer: how much it is strained.
Pack strain_squared(const LayerAxes& axes, const LayerColumns& h) {
  const PackVector t1 = row(axes, 0), t2 = row(axes, 1);
  const Pack e11 = dot(t1, h[0]) + 0.5 * dot(h[0], h[0]), e22 = dot(t2, h[1]) + 0.5 * dot(h[1], h[1]);
  const Pack e12 = 0.5 * (dot(t1, h[1]) + (dot(t2, h[0]) + dot(h[0], h[1])));
  return e11 * e11 + (e22 * e22 + 2.0 * e12 * e12);
}

/// A point on the way to plane stress: w = d - N, P there, and P N.
struct Trial {
  PackVector w;
  Tensor3<Pack> H, P;
  PackVector residual;

  Trial(const LawField& law, std::size_t n, const LayerAxes& axes, const LayerColumns& h, const PackVector& at)
      : w(at), H(gradient_of(axes, h, at)), P(law.P(n, H)), residual(column(P, axes, 2)) {}
};

/// The part of a step along which P N decreases: halves in the lanes where it does not.
Trial damped(const LawField& law, std::size_t n, const LayerAxes& axes, const LayerColumns& h, const Trial& from,
             const PackVector& step, const Pack::mask_type& is_far) {
  constexpr int most_halvings = 40;
  const Pack before = dot(from.residual, from.residual);
  Pack part = 1.0;
  for (int k = 0;; ++k) {
    Trial to(law, n, axes, h, from.w + part * step);
    const auto is_worse = is_far && !(dot(to.residual, to.residual) < before);
    if (!any_of(is_worse) || k == most_halvings) return to;
    part = select(is_worse, Pack(0.5 * part), part);
  }
}

}  // namespace

LayerState PlaneStress::state(std::size_t n, const LayerAxes& axes, const LayerColumns& h) const {
  Tangent<Pack> A;
  return solve(n, axes, h, A);
}

LayerState PlaneStress::solve(std::size_t n, const LayerAxes& axes, const LayerColumns& h, Tangent<Pack>& A) const {
  constexpr int most_iterations = 60;
  const PackVector N = row(axes, 2);
  // The fourth power of a step whose square is lost next to the strain: what it leaves is its square.
  const Pack negligible = 1e-36 * strain_squared(axes, h) + 1e-60;
  Trial at(*law_, n, axes, h, without_change_of_volume(axes, h));
  for (int k = 0;; ++k) {
    law_->tangent(n, at.H, A);
    const PackVector step = Pack(-1.0) * matvec(inverse(across(A, N)), at.residual);
    const Pack size = dot(step, step);
    const auto is_far = size * size > negligible;  // false where it is NaN
    const bool is_last = k == most_iterations;
    if (any_of(is_far) && !is_last) {
      // Lanes that have arrived stay, so that no lane depends on the others.
      PackVector on_the_way = step;
      for (Pack& component : on_the_way) component = select(is_far, component, Pack(0.0));
      at = damped(*law_, n, axes, h, at, on_the_way, is_far);
      continue;
    }
    // The last step changes the stress by its linear part.
    LayerState state{gradient_of(axes, h, at.w + step), {}};
    const Tensor3<Pack> dH = outer(step, N);
    Tensor3<Pack> P = at.P;
    for (int p = 0; p < 9; ++p) {
      for (int q = 0; q < 9; ++q) P.a[p] += A[9 * p + q] * dH.a[q];
    }
    for (int a = 0; a < 2; ++a) {
      state.P[a] = column(P, axes, a);
      for (Pack& component : state.P[a]) {
        component = select(is_far, Pack(std::numeric_limits<double>::quiet_NaN()), component);
      }
    }
    return state;
  }
}

LayerState PlaneStress::tangent(std::size_t n, const LayerAxes& axes, const LayerColumns& h, LayerTangent& T) const {
  Tangent<Pack> A;
  const LayerState state = solve(n, axes, h, A);
  const Tangent<Pack> C = pulled_back(A, axes);
  const auto entry = [&C](int i, int a, int k, int b) -> const Pack& { return C[9 * (3 * i + a) + 3 * k + b]; };
  const Tensor3<Pack> K = inverse(make_tensor([&](int i, int k) -> Pack { return entry(i, 2, k, 2); }));
  std::array<PackVector, 6> B, KB;  // A_fd, and A_dd^-1 A_df
  for (int p = 0; p < 6; ++p) {
    for (int m = 0; m < 3; ++m) B[p][m] = entry(p % 3, p / 3, m, 2);
    KB[p] = matvec(K, B[p]);
  }
  for (int p = 0; p < 6; ++p) {
    for (int q = p; q < 6; ++q) {
      T[6 * p + q] = T[6 * q + p] = entry(p % 3, p / 3, q % 3, q / 3) - dot(B[p], KB[q]);
    }
  }
  return state;
}

}  // namespace pliant
