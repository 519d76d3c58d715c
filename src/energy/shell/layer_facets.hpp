/// The facets of a thin layer in SIMD packs, as fem/cells has the cells of a body. Built once.
#pragma once

#include "base/compensated_sum.hpp"
#include "base/vector3.hpp"
#include "energy/shell/layer_shape.hpp"
#include "energy/shell/plane_stress.hpp"
#include "fem/block_matrix.hpp"
#include "fem/element.hpp"
#include "fem/layout.hpp"
#include "fem/quadrature.hpp"
#include "fem/selection.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace pliant {

/// `pack_size` facets at a time; padding lanes repeat a facet and have no weight.
template <int Order>
struct LayerBatch {
  static constexpr int num_nodes = Triangle<Order>::num_nodes;
  std::array<std::array<PetscInt, pack_size>, num_nodes> nodes;                   ///< local nodes
  std::array<std::array<std::int32_t, pack_size>, num_nodes * num_nodes> blocks;  ///< BlockPattern::block of (a, b)
  int num_lanes = 0;
  Pack owned = 0.0;  ///< 1 where this rank owns the facet
};

/// A quadrature point of the facets of a batch.
template <int Order>
struct LayerPoint {
  LayerAxes axes;
  /// The weights of the nodes in the columns of the layer, f_a = g_a d x/d s_a with the stretch g of the layer [1/m].
  std::array<std::array<Pack, 2>, LayerBatch<Order>::num_nodes> gradients;
  std::array<Pack, 2> stretch;                          ///< g
  Pack weight;                                          ///< volume of the layer [m^3]
  std::array<std::array<double, 3>, pack_size> places;  ///< reference positions [m]
};

/// Those of this rank: owned facets and facets of owned nodes.
template <int Order>
class LayerFacets {
 public:
  static constexpr int num_nodes = LayerBatch<Order>::num_nodes;
  using Nodes = std::array<std::array<Pack, 3>, num_nodes>;

  /// `degree`: up to which the rule integrates polynomials exactly. Throws std::domain_error where `shape.direction`
  /// is at right angles to a facet.
  LayerFacets(const NodeLayout& layout, const BlockPattern& pattern, const FacetList& facets, const LayerShape& shape,
              int degree);

  std::span<const LayerBatch<Order>> batches() const { return batches_; }
  /// Packs of points: `num_points` for each batch.
  std::span<const LayerPoint<Order>> points() const { return points_; }
  std::size_t num_points() const { return num_points_; }
  PetscInt num_owned_nodes() const { return num_owned_nodes_; }

  /// Calls visit(batch, first point, index of that).
  template <class Visit>
  void for_each_batch(const Visit& visit) const {
    for (std::size_t b = 0; b < batches_.size(); ++b)
      visit(batches_[b], points_.data() + b * num_points_, b * num_points_);
  }

  static Nodes gather(const LayerBatch<Order>& batch, std::span<const double> local) {
    Nodes u;
    for (int a = 0; a < num_nodes; ++a) {
      alignas(64) double x[3][pack_size];
      for (int lane = 0; lane < pack_size; ++lane) {
        const double* p = local.data() + 3 * static_cast<std::size_t>(batch.nodes[a][lane]);
        for (int i = 0; i < 3; ++i) x[i][lane] = p[i];
      }
      for (int i = 0; i < 3; ++i) u[a][i].copy_from(x[i], std::experimental::vector_aligned);
    }
    return u;
  }
  /// sum_a w_ab u_a, from differences to the first node: common displacements cancel before they are multiplied.
  static LayerColumns columns(const LayerPoint<Order>& point, const Nodes& u) {
    LayerColumns h{};
    for (int a = 1; a < num_nodes; ++a) {
      for (int i = 0; i < 3; ++i) {
        const Pack d = u[a][i] - u[0][i];
        for (int b = 0; b < 2; ++b) h[b][i] += point.gradients[a][b] * d;
      }
    }
    return h;
  }
  /// The changes of the columns, f_a - t_a, of the layer as it was before it was stretched.
  static LayerColumns changes(const LayerPoint<Order>& point, const Nodes& u) {
    LayerColumns h = columns(point, u);
    for (int b = 0; b < 2; ++b) {
      for (int i = 0; i < 3; ++i) h[b][i] += (point.stretch[b] - 1.0) * point.axes(b, i);
    }
    return h;
  }

  /// Compensated sum of density(index, point, nodes' values ...) over the owned facets; +inf if one is not a number.
  template <class Density>
  double integrate(const Density& density) const {
    CompensatedSum<Pack> total;
    for_each_batch([&](const LayerBatch<Order>& batch, const LayerPoint<Order>* points, std::size_t first) {
      const auto of_point = density(batch);
      for (std::size_t k = 0; k < num_points_; ++k) {
        total.add(select(batch.owned > 0.0, points[k].weight * of_point(first + k, points[k]), Pack(0.0)));
      }
    });
    const double result = sum(total.total());
    return std::isnan(result) ? std::numeric_limits<double>::infinity() : result;
  }

  /// r_a += int P_b w_ab dV; `stress(batch)` returns P_b(index, point) [Pa].
  template <class Stress>
  void add_forces(const Stress& stress, std::span<double> r) const {
    for_each_batch([&](const LayerBatch<Order>& batch, const LayerPoint<Order>* points, std::size_t first) {
      Nodes f{};
      const auto of_point = stress(batch);
      for (std::size_t k = 0; k < num_points_; ++k) {
        const LayerColumns P = of_point(first + k, points[k]);
        for (int a = 0; a < num_nodes; ++a) {
          const Pack g1 = points[k].weight * points[k].gradients[a][0],
                     g2 = points[k].weight * points[k].gradients[a][1];
          for (int i = 0; i < 3; ++i) f[a][i] += g1 * P[0][i] + g2 * P[1][i];
        }
      }
      for (int a = 0; a < num_nodes; ++a) {
        for (int lane = 0; lane < batch.num_lanes; ++lane) {
          for (int i = 0; i < 3; ++i) r[3 * static_cast<std::size_t>(batch.nodes[a][lane]) + i] += f[a][i][lane];
        }
      }
    });
  }

  /// N[facet] += the mean of h P_a (x) f_a / |f_1 x f_2|, the force per length of the deformed layer, xx yy zz xy yz xz
  /// [N/m]; `stress` as above.
  template <class Stress>
  void add_forces_per_length(const Stress& stress, std::span<const double> u,
                             std::span<std::array<double, 6>> N) const {
    constexpr std::array<std::array<std::size_t, 2>, 6> entries{{{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {0, 2}}};
    for_each_batch([&](const LayerBatch<Order>& batch, const LayerPoint<Order>* points, std::size_t first) {
      std::array<Pack, 6> force{};
      Pack area = 0.0;
      const auto of_point = stress(batch);
      const Nodes at = gather(batch, u);
      for (std::size_t k = 0; k < num_points_; ++k) {
        LayerColumns f = changes(points[k], at);
        for (int a = 0; a < 2; ++a) {
          for (int i = 0; i < 3; ++i) f[a][i] += points[k].axes(a, i);
        }
        const Pack f11 = dot(f[0], f[0]), f22 = dot(f[1], f[1]), f12 = dot(f[0], f[1]);
        area += points[k].weight * sqrt(f11 * f22 - f12 * f12);
        const LayerColumns P = of_point(first + k, points[k]);
        for (std::size_t e = 0; e < entries.size(); ++e) {
          const auto [i, j] = entries[e];
          force[e] += points[k].weight * (P[0][i] * f[0][j] + P[1][i] * f[1][j]);
        }
      }
      const std::size_t first_facet = first / num_points_ * pack_size;
      for (int lane = 0; lane < batch.num_lanes; ++lane) {
        for (std::size_t e = 0; e < entries.size(); ++e) {
          N[first_facet + static_cast<std::size_t>(lane)][e] += thickness_ * force[e][lane] / area[lane];
        }
      }
    });
  }

  /// K_ab += int w_ac T_cd w_bd dV on rows of owned nodes; `tangent(batch)` returns T(index, point) [Pa], which may be
  /// unsymmetric.
  template <class TangentOf>
  void add_stiffness(const TangentOf& tangent, const BlockWriter& K) const {
    for_each_batch([&](const LayerBatch<Order>& batch, const LayerPoint<Order>* points, std::size_t first) {
      std::array<std::array<Tensor3<Pack>, num_nodes>, num_nodes> matrix{};
      const auto of_point = tangent(batch);
      for (std::size_t k = 0; k < num_points_; ++k) add_point(points[k], of_point(first + k, points[k]), matrix);
      scatter(batch, matrix, K);
    });
  }

 private:
  using Matrix = std::array<std::array<Tensor3<Pack>, num_nodes>, num_nodes>;
  static void add_point(const LayerPoint<Order>& point, const LayerTangent& T, Matrix& matrix) {
    for (int b = 0; b < num_nodes; ++b) {
      std::array<Pack, 18> column;  // weight T w_b at [3 p + k]
      for (std::size_t p = 0; p < 6; ++p) {
        for (std::size_t k = 0; k < 3; ++k) {
          column[3 * p + k] =
              point.weight * (T[6 * p + k] * point.gradients[b][0] + T[6 * p + 3 + k] * point.gradients[b][1]);
        }
      }
      for (int a = 0; a < num_nodes; ++a) {
        for (std::size_t p = 0; p < 9; ++p) {
          matrix[a][b].a[p] += point.gradients[a][0] * column[p] + point.gradients[a][1] * column[9 + p];
        }
      }
    }
  }
  void scatter(const LayerBatch<Order>& batch, const Matrix& matrix, const BlockWriter& K) const {
    for (int a = 0; a < num_nodes; ++a) {
      alignas(64) double x[num_nodes][9][pack_size];
      for (int b = 0; b < num_nodes; ++b) {
        for (int p = 0; p < 9; ++p) matrix[a][b].a[p].copy_to(x[b][p], std::experimental::vector_aligned);
      }
      for (int lane = 0; lane < batch.num_lanes; ++lane) {
        const PetscInt node = batch.nodes[a][lane];
        if (node >= num_owned_nodes_) continue;
        const BlockWriter::Row row = K.row(node);
        for (int b = 0; b < num_nodes; ++b) {
          const auto [values, stride] = row.block(batch.blocks[a * num_nodes + b][lane]);
          for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) values[i * stride + j] += x[b][3 * i + j][lane];
          }
        }
      }
    }
  }

  std::vector<LayerBatch<Order>> batches_;
  std::vector<LayerPoint<Order>> points_;
  std::size_t num_points_ = 1;
  PetscInt num_owned_nodes_;
  double thickness_;  // before the layer was stretched [m]
};

}  // namespace pliant
