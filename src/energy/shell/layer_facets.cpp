#include "energy/shell/layer_facets.hpp"

#include "base/vector3.hpp"

#include <algorithm>
#include <stdexcept>

namespace pliant {
namespace {

/// A point of one facet.
template <int Order>
struct FacetPoint {
  std::array<Vector3<double>, 3> axes;
  std::array<std::array<double, 2>, Triangle<Order>::num_nodes> gradients;  // dN/ds [1/m]
  double area_factor;                                                       // dA per area of the reference triangle
  Vector3<double> place;
};

/// The axes along the first edge where no direction is given.
Vector3<double> first_axis(const Vector3<double>& along_edge, const Vector3<double>& normal,
                           const std::optional<std::array<double, 3>>& direction) {
  if (!direction) return unit(along_edge);
  const Vector3<double> d = unit(Vector3<double>(*direction)), in_facet = d - dot(d, normal) * normal;
  constexpr double smallest = 1e-3;
  if (norm(in_facet) < smallest) throw std::domain_error("the direction is at right angles to a facet of the surface");
  return unit(in_facet);
}

template <int Order>
FacetPoint<Order> facet_point(const NodeLayout& layout, std::span<const PetscInt> nodes,
                              const std::array<double, 2>& xi, const LayerShape& shape) {
  const auto N = Triangle<Order>::values(xi);
  const auto dN = Triangle<Order>::gradients(xi);
  Vector3<double> X_xi{}, X_eta{};
  FacetPoint<Order> point{};
  for (std::size_t a = 0; a < nodes.size(); ++a) {
    const Vector3<double> X = layout.position(nodes[a]);
    point.place = point.place + N[a] * X;
    X_xi = X_xi + dN[a][0] * X;
    X_eta = X_eta + dN[a][1] * X;
  }
  const Vector3<double> n = cross(X_xi, X_eta);
  point.area_factor = norm(n);
  point.axes[2] = unit(n);
  point.axes[0] = first_axis(X_xi, point.axes[2], shape.direction);
  point.axes[1] = cross(point.axes[2], point.axes[0]);
  // dX = J dxi in the axes; dN/ds = J^-T dN/dxi.
  const double j00 = dot(point.axes[0], X_xi), j01 = dot(point.axes[0], X_eta);
  const double j10 = dot(point.axes[1], X_xi), j11 = dot(point.axes[1], X_eta);
  const double inverse = 1.0 / (j00 * j11 - j01 * j10);
  for (std::size_t a = 0; a < nodes.size(); ++a) {
    point.gradients[a] = {inverse * (j11 * dN[a][0] - j10 * dN[a][1]), inverse * (j00 * dN[a][1] - j01 * dN[a][0])};
  }
  return point;
}

}  // namespace

template <int Order>
LayerFacets<Order>::LayerFacets(const NodeLayout& layout, const BlockPattern& pattern, const FacetList& facets,
                                const LayerShape& shape, int degree)
    : num_owned_nodes_(layout.num_owned_nodes), thickness_(shape.thickness) {
  const auto rule = simplex_rule<2>(degree);
  num_points_ = static_cast<std::size_t>(rule.size());
  for (PetscInt first = 0; first < facets.size(); first += pack_size) {
    LayerBatch<Order>& batch = batches_.emplace_back();
    const std::size_t first_point = points_.size();
    points_.resize(first_point + num_points_);
    batch.num_lanes = std::min<int>(pack_size, facets.size() - first);
    for (int lane = 0; lane < pack_size; ++lane) {
      const bool is_real = lane < batch.num_lanes;
      const PetscInt facet = is_real ? first + lane : facets.size() - 1;
      const auto nodes = facets.nodes_of(facet);
      batch.owned[lane] = is_real && facets.is_owned[facet] != 0 ? 1.0 : 0.0;
      for (int a = 0; a < num_nodes; ++a) {
        batch.nodes[a][lane] = nodes[a];
        for (int b = 0; b < num_nodes; ++b) {
          batch.blocks[a * num_nodes + b][lane] = nodes[a] < num_owned_nodes_ ? pattern.block(nodes[a], nodes[b]) : 0;
        }
      }
      for (std::size_t k = 0; k < num_points_; ++k) {
        const FacetPoint<Order> at = facet_point<Order>(layout, nodes, rule.points[k], shape);
        LayerPoint<Order>& point = points_[first_point + k];
        point.weight[lane] = is_real ? rule.weights[k] * at.area_factor * shape.volume_per_area() : 0.0;
        point.places[lane] = at.place;
        for (int a = 0; a < 3; ++a) {
          for (int i = 0; i < 3; ++i) point.axes(a, i)[lane] = at.axes[a][i];
        }
        for (int b = 0; b < 2; ++b) {
          point.stretch[b][lane] = shape.stretch[b];
          for (int a = 0; a < num_nodes; ++a) point.gradients[a][b][lane] = shape.stretch[b] * at.gradients[a][b];
        }
      }
    }
  }
}

template class LayerFacets<1>;
template class LayerFacets<2>;

}  // namespace pliant
