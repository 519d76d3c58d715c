/// What the elastic terms share beside their energies.
#pragma once

#include "energy/body_cells.hpp"
#include "energy/elastic.hpp"
#include "energy/step_bound.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pliant {

inline Tensor3<double> one_lane(const Tensor3<Pack>& A, int lane) {
  return make_tensor([&](int i, int j) -> double { return A(i, j)[lane]; });
}

/// The largest alpha <= 1 for which no quadrature point of q + alpha d is turned inside out; +inf if none is.
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

/// What is missing from f(H) to f(H') + Df(H') dH, the value extrapolated along the line from H' = H - dH, with the
/// derivative as a central difference; 0 where that is not a number. f: Tensor3<Pack> -> Tensor3<Pack>. Source:
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

/// grad u at the centroids of a batch.
template <int Order>
Tensor3<Pack> centroid_gradient(const CellBatch<Order>& batch, const NodeValues<CellGroup<Order>::num_nodes>& u) {
  return displacement_gradient<Order>(u, Tet<Order>::gradients({0.25, 0.25, 0.25}),
                                      batch.group.inverse_jacobian_at_centroid(batch.number));
}

/// The state at the centroids of a batch.
struct CentroidState {
  Tensor3<Pack> H;  ///< grad u
  Tensor3<Pack> P;  ///< [Pa]
  Pack J;           ///< the volume ratio to be told
  Pack psi;         ///< [J/m^3]
};

/// Calls `visit(local cell, stress)` for the owned cells of a batch.
template <int Order, class Visit>
void visit_stresses(const CellBatch<Order>& batch, const CentroidState& at, const Visit& visit) {
  for (int lane = 0; lane < batch.batch().num_lanes; ++lane) {
    if (batch.batch().owned[lane] == 0.0) continue;
    const Tensor3<double> F = add_to_diagonal(one_lane(at.H, lane), 1.0);
    const Tensor3<double> sigma = (1.0 / det(F)) * matmul(one_lane(at.P, lane), transpose(F));
    const Tensor3<double> s = add_to_diagonal(sigma, -trace(sigma) / 3.0);
    const CellStress stress{{sigma(0, 0), sigma(1, 1), sigma(2, 2), sigma(0, 1), sigma(1, 2), sigma(0, 2)},
                            std::sqrt(1.5 * dot(s, s)),
                            at.J[lane],
                            at.psi[lane]};
    visit(batch.group.cells[batch.number * pack_size + lane], stress);
  }
}

}  // namespace pliant
