/// What terms with a stress have in common: states at centroids, and their report to a visitor.
#pragma once

#include "energy/stress.hpp"
#include "energy/volume/body_cells.hpp"

namespace pliant {

inline Tensor3<double> one_lane(const Tensor3<Pack>& A, int lane) {
  return make_tensor([&](int i, int j) -> double { return A(i, j)[lane]; });
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
  Pack J;           ///< the volume ratio to be reported
  Pack psi;         ///< [J/m^3]
  Pack softening = 0.0;
};

/// Calls `visit(local cell, stress)` for the cells of a batch.
template <int Order, class Visit>
void visit_stresses(const CellBatch<Order>& batch, const CentroidState& at, VisitedCells visited, const Visit& visit) {
  for (int lane = 0; lane < batch.batch().num_lanes; ++lane) {
    if (visited == VisitedCells::owned && batch.batch().owned[lane] == 0.0) continue;
    const Tensor3<double> H = one_lane(at.H, lane), F = add_to_diagonal(H, 1.0);
    const Tensor3<double> sigma = (1.0 / det(F)) * matmul(one_lane(at.P, lane), transpose(F));
    visit(batch.local_cell(lane),
          CellStress{{sigma(0, 0), sigma(1, 1), sigma(2, 2), sigma(0, 1), sigma(1, 2), sigma(0, 2)},
                     H,
                     at.J[lane],
                     at.psi[lane],
                     at.softening[lane]});
  }
}

/// A stress in the reference body and the energy stored with it, at a point or for a cell.
struct PointStress {
  Tensor3<Pack> S{};  ///< second Piola-Kirchhoff, or the stress of a law of small strain [Pa]
  Pack energy = 0.0;  ///< [J/m^3]
  Pack softening = 0.0;
};

/// Whether PointStress::S is pushed forward.
enum class StressMeasure { second_piola_kirchhoff, small_strain };

/// Visits the mean of a stress that is known only at the quadrature points, with the internal variables:
/// `of_batch(CellBatch)` returns a PointStress as a function of a CellPoint.
template <int Order, class OfBatch>
void visit_mean_stresses(const BodyCells<Order>& cells, const BodyState& state, StressMeasure measure,
                         const OfBatch& of_batch, const StressVisitor& visit) {
  cells.for_each_batch([&](const CellBatch<Order>& batch) {
    const auto at_point = of_batch(batch);
    PointStress mean;
    Pack volume = 0.0;
    for (int k = 0; k < batch.group.rule.size(); ++k) {
      const CellPoint<Order> point{batch, k};
      const PointStress there = at_point(point);
      mean.S = mean.S + point.weight() * there.S;
      mean.energy += point.weight() * there.energy;
      mean.softening += point.weight() * there.softening;
      volume += point.weight();
    }
    const Pack share = 1.0 / select(volume > 0.0, volume, Pack(1.0));  // padding lanes have none
    const Tensor3<Pack> H = centroid_gradient(batch, batch.values(state.q)), F = add_to_diagonal(H, 1.0);
    const Tensor3<Pack> S = share * mean.S;
    const bool is_small = measure == StressMeasure::small_strain;
    visit_stresses(batch, {H, is_small ? S : matmul(F, S), det(F), share * mean.energy, share * mean.softening},
                   state.visited, visit);
  });
}

}  // namespace pliant
