#include "energy/load/wetted_surface.hpp"

#include "base/compensated_sum.hpp"
#include "fem/element.hpp"
#include "fem/quadrature.hpp"

#include <algorithm>
#include <cassert>

namespace pliant {

WettedSurface::WettedSurface(const NodeLayout& layout, const BlockPattern& pattern, FacetList facets,
                             int pressure_degree)
    : layout_(layout), facets_(std::move(facets)) {
  assert(std::ranges::all_of(facets_.is_outer, [](char is_outer) { return is_outer != 0; }));
  if (layout.order == 1) {
    set_rule<1>(pressure_degree);
  } else {
    set_rule<2>(pressure_degree);
  }
  for (PetscInt f = 0; f < facets_.size(); ++f) {
    for (const PetscInt a : nodes_of(f)) {
      for (const PetscInt b : nodes_of(f)) blocks_.push_back(a < layout.num_owned_nodes ? pattern.block(a, b) : 0);
    }
  }
}

template <int Order>
void WettedSurface::set_rule(int pressure_degree) {
  // N_a is of degree Order, n of 2 (Order - 1), whatever the motion.
  const auto rule = simplex_rule<2>(Order + 2 * (Order - 1) + pressure_degree);
  for (int p = 0; p < rule.size(); ++p) {
    const auto N = Triangle<Order>::values(rule.points[p]);
    const auto dN = Triangle<Order>::gradients(rule.points[p]);
    Point point{{}, {}, rule.weights[p]};
    std::ranges::copy(N, point.N.begin());
    std::ranges::copy(dN, point.dN.begin());
    points_.push_back(point);
  }
}

std::span<const PetscInt> WettedSurface::nodes_of(PetscInt facet) const {
  return std::span(facets_.nodes).subspan(facet * facets_.nodes_per_facet, facets_.nodes_per_facet);
}

std::array<Vector3<double>, 2> WettedSurface::tangents(std::span<const PetscInt> nodes, const Point& at,
                                                       std::span<const double> q) const {
  std::array<Vector3<double>, 2> x{};
  for (std::size_t a = 0; a < nodes.size(); ++a) {
    const auto X = layout_.position(nodes[a]);
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 2; ++k) x[k][i] += at.dN[a][k] * (X[i] + q[3 * nodes[a] + i]);
    }
  }
  return x;
}

std::vector<double> WettedSurface::weighted(double pressure) const {
  std::vector<double> result;
  result.reserve(points_.size() * facets_.size());
  for (PetscInt f = 0; f < facets_.size(); ++f) {
    for (const Point& point : points_) result.push_back(point.weight * pressure);
  }
  return result;
}

std::vector<double> WettedSurface::weighted(const Expression& pressure, double time) const {
  if (!pressure.depends_on_space()) return weighted(pressure(0.0, 0.0, 0.0, time));
  std::vector<double> result;
  result.reserve(points_.size() * facets_.size());
  for (PetscInt f = 0; f < facets_.size(); ++f) {
    const auto nodes = nodes_of(f);
    for (const Point& point : points_) {
      Vector3<double> X{};
      for (std::size_t a = 0; a < nodes.size(); ++a) X = X + point.N[a] * layout_.position(nodes[a]);
      result.push_back(point.weight * pressure(X[0], X[1], X[2], time));
    }
  }
  return result;
}

double WettedSurface::work(std::span<const double> pressures, std::span<const double> from,
                           std::span<const double> to) const {
  // Along x + s d, n is of second degree in s: int_0^1 n ds = n(1/2) + (d_xi cross d_eta)/12.
  CompensatedSum<double> total;
  for (PetscInt f = 0; f < facets_.size(); ++f) {
    if (!facets_.is_owned[f]) continue;
    const auto nodes = nodes_of(f);
    for (std::size_t k = 0; k < points_.size(); ++k) {
      const Point& point = points_[k];
      const auto [x_xi, x_eta] = tangents(nodes, point, from);
      Vector3<double> d{}, d_xi{}, d_eta{};
      for (std::size_t a = 0; a < nodes.size(); ++a) {
        for (int i = 0; i < 3; ++i) {
          const double change = to[3 * nodes[a] + i] - from[3 * nodes[a] + i];
          d[i] += point.N[a] * change;
          d_xi[i] += point.dN[a][0] * change;
          d_eta[i] += point.dN[a][1] * change;
        }
      }
      const auto n = cross(x_xi + 0.5 * d_xi, x_eta + 0.5 * d_eta) + (1.0 / 12.0) * cross(d_xi, d_eta);
      total.add(pressures[f * points_.size() + k] * dot(n, d));
    }
  }
  return total.total();
}

void WettedSurface::add_forces(std::span<const double> pressures, std::span<const double> q,
                               std::span<double> r) const {
  for (PetscInt f = 0; f < facets_.size(); ++f) {
    const auto nodes = nodes_of(f);
    for (std::size_t k = 0; k < points_.size(); ++k) {
      const auto [x_xi, x_eta] = tangents(nodes, points_[k], q);
      const auto pn = pressures[f * points_.size() + k] * cross(x_xi, x_eta);
      for (std::size_t a = 0; a < nodes.size(); ++a) {
        for (int i = 0; i < 3; ++i) r[3 * nodes[a] + i] += points_[k].N[a] * pn[i];
      }
    }
  }
}

void WettedSurface::add_tangent(std::span<const double> pressures, std::span<const double> q,
                                const BlockWriter& K) const {
  const auto n = static_cast<std::size_t>(facets_.nodes_per_facet);
  for (PetscInt f = 0; f < facets_.size(); ++f) {
    const auto nodes = nodes_of(f);
    for (std::size_t k = 0; k < points_.size(); ++k) {
      const auto& [N, dN, weight] = points_[k];
      const auto [x_xi, x_eta] = tangents(nodes, points_[k], q);
      const double p = pressures[f * points_.size() + k];
      for (std::size_t b = 0; b < n; ++b) {
        const auto v = dN[b][1] * x_xi - dN[b][0] * x_eta;  // the block is p N_a [v]
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
