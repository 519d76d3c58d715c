#include "energy/pressure.hpp"

#include "fem/element.hpp"
#include "fem/quadrature.hpp"

#include <algorithm>
#include <cassert>

namespace pliant {

FollowerPressure::FollowerPressure(const NodeLayout& layout, const BlockPattern& pattern, FacetList facets,
                                   Expression pressure)
    : layout_(layout), facets_(std::move(facets)), pressure_(std::move(pressure)) {
  assert(std::ranges::all_of(facets_.is_outer, [](char is_outer) { return is_outer != 0; }));
  if (layout.order == 1) {
    set_rule<1>();
  } else {
    set_rule<2>();
  }
  for (PetscInt f = 0; f < facets_.size(); ++f) {
    for (const PetscInt a : nodes_of(f)) {
      for (const PetscInt b : nodes_of(f)) blocks_.push_back(a < layout.num_owned_nodes ? pattern.block(a, b) : 0);
    }
  }
}

template <int Order>
void FollowerPressure::set_rule() {
  // N_a is of degree Order, n of 2 (Order - 1), whatever the motion; a pressure that varies in space adds to that.
  const auto rule = simplex_rule<2>(Order + 2 * (Order - 1) + (pressure_.depends_on_space() ? 4 : 0));
  for (int p = 0; p < rule.size(); ++p) {
    const auto N = Triangle<Order>::values(rule.points[p]);
    const auto dN = Triangle<Order>::gradients(rule.points[p]);
    Point point{{}, {}, rule.weights[p]};
    std::ranges::copy(N, point.N.begin());
    std::ranges::copy(dN, point.dN.begin());
    points_.push_back(point);
  }
}

std::span<const PetscInt> FollowerPressure::nodes_of(PetscInt facet) const {
  return std::span(facets_.nodes).subspan(facet * facets_.nodes_per_facet, facets_.nodes_per_facet);
}

std::array<std::array<double, 3>, 2> FollowerPressure::tangents(std::span<const PetscInt> nodes, const Point& at,
                                                                std::span<const double> q) const {
  std::array<std::array<double, 3>, 2> x{};
  for (std::size_t a = 0; a < nodes.size(); ++a) {
    const auto X = layout_.position(nodes[a]);
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 2; ++k) x[k][i] += at.dN[a][k] * (X[i] + q[3 * nodes[a] + i]);
    }
  }
  return x;
}

std::vector<double> FollowerPressure::weighted_pressures(const LocalStage& stage) const {
  std::vector<double> result;
  result.reserve(points_.size() * facets_.size());
  const bool is_uniform = !pressure_.depends_on_space();
  const double everywhere = is_uniform ? pressure_(0.0, 0.0, 0.0, stage.time) : 0.0;
  for (PetscInt f = 0; f < facets_.size(); ++f) {
    const auto nodes = nodes_of(f);
    for (const Point& point : points_) {
      std::array<double, 3> X{};
      for (std::size_t a = 0; a < nodes.size() && !is_uniform; ++a) {
        for (int i = 0; i < 3; ++i) X[i] += point.N[a] * layout_.position(nodes[a])[i];
      }
      const double p = is_uniform ? everywhere : pressure_(X[0], X[1], X[2], stage.time);
      result.push_back(stage.load_factor * point.weight * p);
    }
  }
  return result;
}

void FollowerPressure::add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const {
  const auto pressures = weighted_pressures(stage);
  for (PetscInt f = 0; f < facets_.size(); ++f) {
    const auto nodes = nodes_of(f);
    for (std::size_t k = 0; k < points_.size(); ++k) {
      const auto [x, y] = tangents(nodes, points_[k], q);
      const double p = pressures[f * points_.size() + k];
      const std::array<double, 3> pn{p * (x[1] * y[2] - x[2] * y[1]), p * (x[2] * y[0] - x[0] * y[2]),
                                     p * (x[0] * y[1] - x[1] * y[0])};
      for (std::size_t a = 0; a < nodes.size(); ++a) {
        for (int i = 0; i < 3; ++i) r[3 * nodes[a] + i] += points_[k].N[a] * pn[i];
      }
    }
  }
}

void FollowerPressure::add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                                   Projection projection) const {
  if (projection == Projection::positive_semidefinite) return;
  const auto pressures = weighted_pressures(stage);
  const auto n = static_cast<std::size_t>(facets_.nodes_per_facet);
  for (PetscInt f = 0; f < facets_.size(); ++f) {
    const auto nodes = nodes_of(f);
    for (std::size_t k = 0; k < points_.size(); ++k) {
      const auto& [N, dN, weight] = points_[k];
      const auto [x, y] = tangents(nodes, points_[k], q);
      const double p = pressures[f * points_.size() + k];
      for (std::size_t b = 0; b < n; ++b) {
        std::array<double, 3> v;  // the block is p N_a [v]
        for (int i = 0; i < 3; ++i) v[i] = dN[b][1] * x[i] - dN[b][0] * y[i];
        for (std::size_t a = 0; a < n; ++a) {
          if (nodes[a] >= layout_.num_owned_nodes) continue;
          const auto [values, stride] = K.block(nodes[a], blocks_[(f * n + a) * n + b]);
          for (int i = 0; i < 3; ++i) {
            const int j = (i + 1) % 3, l = (i + 2) % 3;  // [v]_ij = -v_l, [v]_ji = v_l
            values[i * stride + j] -= p * N[a] * v[l];
            values[j * stride + i] += p * N[a] * v[l];
          }
        }
      }
    }
  }
}

}  // namespace pliant
