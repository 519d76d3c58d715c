/// What the elastic terms have in common, except for their energies.
#pragma once

#include "energy/volume/cell_stresses.hpp"
#include "energy/volume/elastic.hpp"
#include "energy/volume/step_bound.hpp"

#include <algorithm>
#include <limits>

namespace pliant {

/// The largest alpha <= 1 for which no quadrature point of q + alpha d is inverted; +inf if none is.
template <int Order>
double step_to_inversion(const BodyCells<Order>& cells, std::span<const double> q, std::span<const double> d) {
  double step = std::numeric_limits<double>::infinity();
  cells.for_each_batch([&](const CellBatch<Order>& batch) {
    const auto u = batch.values(q), du = batch.values(d);
    for (int k = 0; k < batch.group.rule.size(); ++k) {
      const CellPoint<Order> point{batch, k};
      const Tensor3<Pack> F = add_to_diagonal(point.gradient(u), 1.0), dF = point.gradient(du);
      if (!may_invert(F, dF)) continue;
      for (int lane = 0; lane < batch.batch().num_lanes; ++lane) {
        step = std::min(step, first_inversion(one_lane(F, lane), one_lane(dF, lane)));
      }
    }
  });
  return step;
}

/// S = F^-1 P, the second Piola-Kirchhoff stress [Pa].
PLIANT_INLINE Tensor3<Pack> second_stress(const Tensor3<Pack>& H, const Tensor3<Pack>& P) {
  const Tensor3<Pack> F = add_to_diagonal(H, 1.0);
  return (1.0 / det(F)) * matmul(transpose(cofactor(F)), P);
}

/// The difference between f(H) and f(H') + Df(H') dH, the value extrapolated along the line from H' = H - dH, with the
/// derivative as a central difference; 0 where it is NaN. f: Tensor3<Pack> -> Tensor3<Pack>. Source:
/// Magisano, Leonetti & Garcea 2017, "How to improve efficiency and robustness of the Newton method in geometrically
/// non-linear structural problem discretized via displacement-based finite elements", with the stresses of points that
/// are functions of the displacements: only the tangent sees the extrapolated ones.
template <class Function>
Tensor3<Pack> extrapolation_error(const Function& f, const Tensor3<Pack>& H, const Tensor3<Pack>& dH) {
  constexpr double part = 1e-3;
  const Tensor3<Pack> before = H - dH;
  const Tensor3<Pack> extrapolated = f(before) + (0.5 / part) * (f(before + part * dH) - f(before - part * dH));
  Tensor3<Pack> error = extrapolated - f(H);
  for (Pack& e : error.a) e = select(std::experimental::isfinite(e), e, Pack(0.0));
  return error;
}

/// A_iJkL += delta_ik S_JL.
PLIANT_INLINE void add_geometric_stiffness(const Tensor3<Pack>& S, Tangent<Pack>& A) {
  for (int i = 0; i < 3; ++i) {
    for (int J = 0; J < 3; ++J) {
      for (int L = 0; L < 3; ++L) A[9 * (3 * i + J) + 3 * i + L] += 0.5 * (S(J, L) + S(L, J));
    }
  }
}

}  // namespace pliant
