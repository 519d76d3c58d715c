/// The error of a displacement gradient, measured by a better one that was recovered from it: in a cell
///
///     e = 1/2 int (S(H*) - S(H)) : (E(H*) - E(H)) dX
///
/// with H = grad u of the elements, H* the recovered one, S the second Piola-Kirchhoff stress of the elastic law and E
/// the Green-Lagrange strain: the same for all rotations. For a linear law it is the energy of the difference of the
/// stresses; its sum over the body is then about the difference between the energies of the solution and of its
/// approximation. Source: Zienkiewicz & Zhu, Int. J. Numer. Methods Eng. 33 (1992) 1331-1382.
#pragma once

#include "energy/volume/cell_stresses.hpp"
#include "energy/volume/elastic.hpp"
#include "energy/volume/elastic_cells.hpp"
#include "fem/quadrature.hpp"
#include "material/kinematics.hpp"

#include <span>
#include <vector>

namespace pliant {

/// The points of a batch's cells at which both gradients are compared: those of a rule that is exact for the square of
/// their difference on straight cells.
template <int Order>
class RecoveryPoints {
 public:
  void set(const CellBatch<Order>& batch, const RecoveredState& state) {
    static const QuadratureRule<3> rule = simplex_rule<3>(2 * Order);
    constexpr int num_nodes = Tet<Order>::num_nodes;
    const auto X = batch.values(state.X), u = batch.values(state.q);
    std::array<Tensor3<Pack>, num_nodes> at_nodes;
    for (int a = 0; a < num_nodes; ++a) {
      const auto& lanes = batch.batch().nodes[a];
      for (std::size_t c = 0; c < 9; ++c) {
        at_nodes[a].a[c] = Pack([&](auto lane) { return state.gradients[9 * lanes[lane] + c]; });
      }
    }
    points = rule.points;
    weights.clear();
    gradients.clear();
    recovered.clear();
    for (int k = 0; k < rule.size(); ++k) {
      const auto dN = Tet<Order>::gradients(rule.points[k]);
      const auto N = Tet<Order>::values(rule.points[k]);
      const Tensor3<Pack> jacobian = displacement_gradient<Order>(X, dN, identity<Pack>());
      const Pack volume = det(jacobian);
      weights.push_back(rule.weights[k] * volume);
      gradients.push_back(displacement_gradient<Order>(u, dN, Pack(1.0 / volume) * transpose(cofactor(jacobian))));
      Tensor3<Pack> mean{};
      for (int a = 0; a < num_nodes; ++a) mean = mean + N[a] * at_nodes[a];
      recovered.push_back(mean);
    }
  }
  std::size_t size() const { return weights.size(); }

  std::vector<std::array<double, 3>> points;  ///< on the reference tetrahedron
  std::vector<Pack> weights;                  ///< reference volumes [m^3]
  std::vector<Tensor3<Pack>> gradients;       ///< grad u of the elements
  std::vector<Tensor3<Pack>> recovered;       ///< the recovered one
};

/// 1/2 (S* - S) : (E* - E) at a point, from first Piola-Kirchhoff stresses; 0 where a law has no stress.
inline Pack recovery_error(const Tensor3<Pack>& H, const Tensor3<Pack>& P, const Tensor3<Pack>& recovered,
                           const Tensor3<Pack>& P_recovered, StressMeasure measure) {
  const Tensor3<Pack> dH = recovered - H;
  const Pack e =
      measure == StressMeasure::small_strain
          ? 0.5 * dot(P_recovered - P, small_strain(dH))
          : 0.5 * dot(second_stress(recovered, P_recovered) - second_stress(H, P), green_lagrange_change(H, dH));
  return select(std::experimental::isfinite(e), e, Pack(0.0));
}

/// Visits the local cells of a body; `stresses_of(batch, points, gradients)` are first Piola-Kirchhoff stresses, one at
/// each point.
template <int Order, class StressesOf>
void visit_recovery_errors(const BodyCells<Order>& cells, const RecoveredState& state, StressMeasure measure,
                           const StressesOf& stresses_of, const RecoveryErrorVisitor& visit) {
  RecoveryPoints<Order> at;
  cells.for_each_batch([&](const CellBatch<Order>& batch) {
    at.set(batch, state);
    const std::vector<Tensor3<Pack>> P = stresses_of(batch, at, at.gradients), R = stresses_of(batch, at, at.recovered);
    Pack energy = 0.0, volume = 0.0;
    for (std::size_t k = 0; k < at.size(); ++k) {
      energy += at.weights[k] * recovery_error(at.gradients[k], P[k], at.recovered[k], R[k], measure);
      volume += at.weights[k];
    }
    for (int lane = 0; lane < batch.batch().num_lanes; ++lane) {
      visit(batch.local_cell(lane), RecoveryError{std::max<double>(energy[lane], 0.0), volume[lane]});
    }
  });
}

/// Likewise of a law alone, which has its packs at the index of each cell's first point.
template <int Order>
void visit_recovery_errors(const BodyCells<Order>& cells, const RecoveredState& state, const LawField& law,
                           const RecoveryErrorVisitor& visit) {
  const auto stresses_of = [&](const CellBatch<Order>& batch, const RecoveryPoints<Order>&,
                               std::span<const Tensor3<Pack>> gradients) {
    std::vector<Tensor3<Pack>> P;
    for (const Tensor3<Pack>& H : gradients) P.push_back(law.P(CellPoint<Order>{batch, 0}.index(), H));
    return P;
  };
  visit_recovery_errors(
      cells, state, law.traits().constant_tangent ? StressMeasure::small_strain : StressMeasure::second_piola_kirchhoff,
      stresses_of, visit);
}

}  // namespace pliant
