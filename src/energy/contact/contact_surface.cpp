#include "energy/contact/contact_surface.hpp"

#include "collision/contact_pairs.hpp"
#include "fem/element.hpp"
#include "fem/quadrature.hpp"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

/// Corners, edge midpoints and centre of the reference triangle, exact for degree 3.
QuadratureRule<2> nodal_rule() {
  return {{{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}, {0.5, 0.0}, {0.5, 0.5}, {0.0, 0.5}, {1.0 / 3, 1.0 / 3}},
          {1.0 / 40, 1.0 / 40, 1.0 / 40, 1.0 / 15, 1.0 / 15, 1.0 / 15, 9.0 / 40}};
}

/// Six points, exact for degree 4: Strang & Fix 1973, An Analysis of the Finite Element Method, table 4.1.
QuadratureRule<2> inner_rule() {
  QuadratureRule<2> rule;
  for (const auto& [a, weight] :
       {std::array{0.445948490915965, 0.223381589678011}, std::array{0.091576213509771, 0.109951743655322}}) {
    for (const auto& point : {std::array{a, a}, {1.0 - 2.0 * a, a}, {a, 1.0 - 2.0 * a}}) {
      rule.points.push_back(point);
      rule.weights.push_back(0.5 * weight);
    }
  }
  return rule;
}

}  // namespace

ContactSurface::ContactSurface(const NodeLayout& layout, const BlockPattern& pattern, FacetList facets,
                               const NormalLaw& law, double thickness)
    : layout_(layout), facets_(std::move(facets)), law_(law) {
  const QuadratureRule<2> rule = law.kind == NormalKind::barrier ? nodal_rule() : inner_rule();
  if (thickness > 0.0) {
    set_points_of_segments(thickness);
  } else if (layout.order == 1) {
    set_points<1>(rule.points, rule.weights);
  } else {
    set_points<2>(rule.points, rule.weights);
  }
  for (PetscInt f = 0; f < facets_.size(); ++f) {
    const auto nodes = nodes_of(f);
    const auto is_owned = [&](PetscInt a) { return a < layout.num_owned_nodes; };
    has_owned_node_.push_back(std::ranges::any_of(nodes, is_owned));
    for (const PetscInt a : nodes) {
      for (const PetscInt b : nodes) blocks_.push_back(is_owned(a) ? pattern.block(a, b) : 0);
    }
  }
}

template <int Order>
void ContactSurface::set_points(std::span<const std::array<double, 2>> points, std::span<const double> weights) {
  num_points_ = points.size();
  for (const auto& xi : points) {
    const auto N = Triangle<Order>::values(xi);
    shape_functions_.insert(shape_functions_.end(), N.begin(), N.end());
    double sum = 0.0;
    for (const double N_a : N) sum += std::abs(N_a);
    overshoot_ = std::max(overshoot_, sum);
  }
  for (PetscInt f = 0; f < facets_.size(); ++f) {
    const auto nodes = nodes_of(f);
    for (std::size_t k = 0; k < points.size(); ++k) {
      const auto dN = Triangle<Order>::gradients(points[k]);
      Vector3<double> X_xi{}, X_eta{};
      for (std::size_t a = 0; a < nodes.size(); ++a) {
        const Vector3<double> X = layout_.position(nodes[a]);
        X_xi = X_xi + dN[a][0] * X;
        X_eta = X_eta + dN[a][1] * X;
      }
      areas_.push_back(weights[k] * norm(cross(X_xi, X_eta)));
    }
  }
}

void ContactSurface::set_points_of_segments(double thickness) {
  const std::array<LinePoint, 5> rule = lobatto_rule();
  num_points_ = rule.size();
  for (const auto& [s, weight] : rule) {
    std::vector<double> N(static_cast<std::size_t>(facets_.nodes_per_facet), 0.0);
    N[0] = 1.0 - s;
    N[1] = s;
    shape_functions_.insert(shape_functions_.end(), N.begin(), N.end());
  }
  for (PetscInt f = 0; f < facets_.size(); ++f) {
    const auto nodes = nodes_of(f);
    const double length = norm(layout_.position(nodes[1]) - layout_.position(nodes[0]));
    for (const auto& [s, weight] : rule) areas_.push_back(weight * thickness * length);
  }
}

ContactSurface::Ball ContactSurface::ball(PetscInt facet, std::span<const double> q) const {
  const auto nodes = nodes_of(facet);
  Ball result;
  for (const PetscInt node : nodes) result.centre = result.centre + position(node, q);
  result.centre = (1.0 / static_cast<double>(nodes.size())) * result.centre;
  for (const PetscInt node : nodes) result.radius = std::max(result.radius, norm(position(node, q) - result.centre));
  result.radius *= overshoot_;
  return result;
}

bool ContactSurface::is_near(PetscInt facet, const ObstacleFrame& obstacle, std::span<const double> q) const {
  const Ball around = ball(facet, q);
  // NaN must be noticed where forces are summed.
  return !(obstacle.distance(around.centre) > law_.reach() + around.radius);
}

void ContactSurface::add_stiffness(const Point& point, const Tensor3<double>& D, const BlockWriter& K) const {
  const std::size_t n = point.nodes.size();
  for (std::size_t a = 0; a < n; ++a) {
    if (point.nodes[a] >= layout_.num_owned_nodes) continue;
    for (std::size_t b = 0; b < n; ++b) {
      const auto [values, stride] = K.block(point.nodes[a], point.blocks[a * n + b]);
      const double weight = point.N[a] * point.N[b];
      if (weight == 0.0) continue;
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) values[i * stride + j] += weight * D(i, j);
      }
    }
  }
}

}  // namespace pliant
