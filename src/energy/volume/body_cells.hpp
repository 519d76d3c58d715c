/// Loops over the packed cells of one body, for terms that integrate a function of grad u over it.
#pragma once

#include "base/compensated_sum.hpp"
#include "energy/volume/cell_matrix.hpp"
#include "material/law.hpp"

#include <cmath>
#include <limits>
#include <span>
#include <vector>

namespace pliant {

/// A batch of a body's cells.
template <int Order>
struct CellBatch {
  const CellGroup<Order>& group;
  std::size_t number;       ///< its index in its group
  std::size_t first_cell;   ///< number of lane 0's cell among the rank's cells of the body, as the loops meet them
  std::size_t first_point;  ///< number of its first pack of points, likewise

  const auto& batch() const { return group.batches[number]; }
  PLIANT_INLINE auto values(std::span<const double> local) const { return gather<Order>(batch(), local.data()); }
  /// a - b, node by node.
  PLIANT_INLINE auto change(std::span<const double> a, std::span<const double> b) const {
    auto d = values(a);
    const auto u = values(b);
    for (std::size_t n = 0; n < d.size(); ++n) {
      for (int i = 0; i < 3; ++i) d[n][i] -= u[n][i];
    }
    return d;
  }
  PetscInt local_cell(int lane) const { return group.cells[number * pack_size + static_cast<std::size_t>(lane)]; }
  /// Adds the lanes' values to those of their local cells.
  void add_to_cells(const Pack& value, std::span<double> of_cells) const {
    for (int lane = 0; lane < batch().num_lanes; ++lane) of_cells[local_cell(lane)] += value[lane];
  }
  /// Index among the rank's cells of the body; padding lanes have that of the cell they repeat.
  std::size_t cell(int lane) const { return first_cell + (lane < batch().num_lanes ? lane : 0); }
};

/// A quadrature point of the cells of a batch.
template <int Order>
struct CellPoint {
  const CellBatch<Order>& in;
  int number;

  /// Index of the pack among those of the body's quadrature points on this rank.
  std::size_t index() const { return in.first_point + static_cast<std::size_t>(number); }
  PLIANT_INLINE decltype(auto) shape_gradients() const { return in.group.gradients(number); }
  PLIANT_INLINE const Tensor3<Pack>& inverse_jacobian() const {
    return in.group.inverse_jacobian[in.group.geometry(in.number, number)];
  }
  /// Reference volume of the point [m^3]; 0 in padding lanes.
  PLIANT_INLINE Pack weight() const {
    return in.group.rule.weights[number] * in.group.jacobian[in.group.geometry(in.number, number)];
  }
  PLIANT_INLINE Tensor3<Pack> gradient(const NodeValues<CellGroup<Order>::num_nodes>& u) const {
    return displacement_gradient<Order>(u, shape_gradients(), inverse_jacobian());
  }
};

/// S = P . (dxi/dX)^T: the stress that multiplies gradients on the reference cell.
PLIANT_INLINE Tensor3<Pack> pulled_back(const Tensor3<Pack>& P, const Tensor3<Pack>& inverse_jacobian) {
  return matmul(P, transpose(inverse_jacobian));
}

/// C_{i alpha k beta} = A_{iJkL} (dxi_alpha/dX_J) (dxi_beta/dX_L), at [9 (3 i + alpha) + 3 k + beta].
PLIANT_INLINE Tangent<Pack> pulled_back(const Tangent<Pack>& A, const Tensor3<Pack>& inverse_jacobian) {
  Tangent<Pack> half;
  for (int p = 0; p < 9; ++p) {
    for (int k = 0; k < 3; ++k) {
      for (int beta = 0; beta < 3; ++beta) {
        half[9 * p + 3 * k + beta] = A[9 * p + 3 * k] * inverse_jacobian(beta, 0) +
                                     A[9 * p + 3 * k + 1] * inverse_jacobian(beta, 1) +
                                     A[9 * p + 3 * k + 2] * inverse_jacobian(beta, 2);
      }
    }
  }
  Tangent<Pack> C;
  for (int i = 0; i < 3; ++i) {
    for (int alpha = 0; alpha < 3; ++alpha) {
      for (int q = 0; q < 9; ++q) {
        C[9 * (3 * i + alpha) + q] = half[9 * (3 * i) + q] * inverse_jacobian(alpha, 0) +
                                     half[9 * (3 * i + 1) + q] * inverse_jacobian(alpha, 1) +
                                     half[9 * (3 * i + 2) + q] * inverse_jacobian(alpha, 2);
      }
    }
  }
  return C;
}

/// The cells of one body on this rank, ghosts included. Integrands are given in two steps, so that the data of a batch
/// are gathered once: `of_batch(CellBatch)` returns a function of a CellPoint.
template <int Order>
class BodyCells {
  using Group = CellGroup<Order>;
  static constexpr int num_nodes = Group::num_nodes;

 public:
  /// `groups` holds the cells of all bodies and must outlive the object.
  BodyCells(const CellGroups<Order>& groups, int body, PetscInt num_owned_nodes) : num_owned_nodes_(num_owned_nodes) {
    for (const Group& group : groups) {
      if (group.body == body) groups_.push_back(&group);
    }
  }

  /// Calls `visit(CellBatch)`.
  template <class Visit>
  PLIANT_INLINE void for_each_batch(Visit visit) const {
    std::size_t first_cell = 0, first_point = 0;
    for (const Group* group : groups_) {
      for (std::size_t b = 0; b < group->batches.size(); ++b) {
        visit(CellBatch<Order>{*group, b, first_cell, first_point});
        first_cell += static_cast<std::size_t>(group->batches[b].num_lanes);
        first_point += static_cast<std::size_t>(group->rule.size());
      }
    }
  }

  /// Compensated sum over the owned cells of int density dX; +inf if a density is not a number.
  template <class DensityOf>
  double integrate(DensityOf density_of) const {
    CompensatedSum<Pack> total;
    for_each_batch([&](const CellBatch<Order>& batch) __attribute__((always_inline)) {
      const auto density = density_of(batch);
      const Pack& owned = batch.batch().owned;
      for (int k = 0; k < batch.group.rule.size(); ++k) {
        const CellPoint<Order> point{batch, k};
        total.add(select(owned > 0.0, point.weight() * density(point), Pack(0.0)));  // a ghost's +inf times 0 is NaN
      }
    });
    const double result = sum(total.total());
    return std::isnan(result) ? std::numeric_limits<double>::infinity() : result;
  }

  /// r_a += int P . dN_a/dX dX, P the first Piola-Kirchhoff stress [Pa].
  template <class StressOf>
  void add_forces(StressOf stress_of, std::span<double> r) const {
    for_each_batch([&](const CellBatch<Order>& batch) __attribute__((always_inline)) {
      const auto f = nodal_forces(batch, stress_of(batch), [](const CellPoint<Order>& p) { return p.weight(); });
      scatter_add<Order>(batch.batch(), f, r.data());
    });
  }

  /// The same with each point counted once, whatever its volume: derivatives of functions of grad u at points.
  template <class SlopeOf>
  void add_slopes_of_points(SlopeOf slope_of, std::span<double> r) const {
    for_each_batch([&](const CellBatch<Order>& batch) {
      const auto f = nodal_forces(batch, slope_of(batch), [](const CellPoint<Order>&) { return Pack(1.0); });
      scatter_add<Order>(batch.batch(), f, r.data());
    });
  }

  /// works += int P : grad d dX of each local cell.
  template <class StressOf>
  void add_works(StressOf stress_of, std::span<const double> d, std::span<double> works) const {
    for_each_batch([&](const CellBatch<Order>& batch) {
      const auto stress = stress_of(batch);
      const auto change = batch.values(d);
      Pack work = 0.0;
      for (int k = 0; k < batch.group.rule.size(); ++k) {
        const CellPoint<Order> point{batch, k};
        work += point.weight() * dot(stress(point), point.gradient(change));
      }
      batch.add_to_cells(work, works);
    });
  }

  /// K_ab += int dN_a/dX . A . dN_b/dX dX on rows of owned nodes, A the symmetric tangent dP/dF [Pa].
  template <class TangentOf>
  void add_stiffness(TangentOf tangent_of, const BlockWriter& K) const {
    CellMatrix<num_nodes> matrix;
    std::vector<LinearMatrix> points;
    for_each_batch([&](const CellBatch<Order>& batch) __attribute__((always_inline)) {
      const auto tangent = tangent_of(batch);
      points.resize(static_cast<std::size_t>(batch.group.rule.size()));
      for (int k = 0; k < batch.group.rule.size(); ++k) {
        const CellPoint<Order> point{batch, k};
        set_linear_matrix(tangent(point), point.inverse_jacobian(), point.weight(),
                          points[static_cast<std::size_t>(k)]);
      }
      set_cell_matrix<Order>(batch.group, points, matrix);
      scatter_add(batch.group, batch.number, num_owned_nodes_, matrix, K);
    });
  }

  /// Packs of quadrature points on this rank (CellPoint::index).
  std::size_t num_packs() const {
    std::size_t total = 0;
    for (const Group* group : groups_) total += group->batches.size() * static_cast<std::size_t>(group->rule.size());
    return total;
  }

  /// Quadrature points on this rank.
  std::size_t num_points() const {
    std::size_t total = 0;
    for_each_batch([&](const CellBatch<Order>& batch) {
      total += static_cast<std::size_t>(batch.batch().num_lanes * batch.group.rule.size());
    });
    return total;
  }

 private:
  template <class Stress, class Weight>
  PLIANT_INLINE static NodeValues<num_nodes> nodal_forces(const CellBatch<Order>& batch, const Stress& stress,
                                                          Weight weight) {
    NodeValues<num_nodes> f{};
    for (int k = 0; k < batch.group.rule.size(); ++k) {
      const CellPoint<Order> point{batch, k};
      const auto& dN = point.shape_gradients();
      const Tensor3<Pack> S = weight(point) * pulled_back(stress(point), point.inverse_jacobian());
      for (int a = 0; a < num_nodes; ++a) {
        for (int i = 0; i < 3; ++i) f[a][i] += S(i, 0) * dN[a][0] + S(i, 1) * dN[a][1] + S(i, 2) * dN[a][2];
      }
    }
    return f;
  }

  std::vector<const Group*> groups_;
  PetscInt num_owned_nodes_;
};

}  // namespace pliant
