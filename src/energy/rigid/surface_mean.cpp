#include "energy/rigid/surface_mean.hpp"

#include "fem/element.hpp"
#include "fem/quadrature.hpp"
#include "petsc/collective.hpp"

#include <cmath>
#include <map>

namespace pliant {
namespace {

/// A surface narrower than this, relative to its length, is a line.
constexpr double narrowest = 1e-6;

/// Visits the points of a quadrature rule on each facet: `visit(facet, X, N, dA)`.
template <int Order, class Visit>
void for_each_point(const NodeLayout& layout, const FacetList& facets, const Visit& visit) {
  // N, X - X_m, and the area of a curved facet, as a polynomial of the degree of x_xi cross x_eta.
  const auto rule = simplex_rule<2>(2 * Order + 2 * (Order - 1));
  for (PetscInt f = 0; f < facets.size(); ++f) {
    const auto nodes = facets.nodes_of(f);
    for (int p = 0; p < rule.size(); ++p) {
      const auto N = Triangle<Order>::values(rule.points[p]);
      const auto dN = Triangle<Order>::gradients(rule.points[p]);
      Vector3<double> X{}, X_xi{}, X_eta{};
      for (std::size_t a = 0; a < nodes.size(); ++a) {
        const Vector3<double> at = layout.position(nodes[a]);
        X = X + N[a] * at;
        X_xi = X_xi + dN[a][0] * at;
        X_eta = X_eta + dN[a][1] * at;
      }
      visit(f, X, N, rule.weights[p] * norm(cross(X_xi, X_eta)));
    }
  }
}

template <int Order>
SurfaceMean mean_of(const NodeLayout& layout, const FacetList& facets) {
  std::array<double, 4> sums{};
  for_each_point<Order>(layout, facets, [&](PetscInt f, const Vector3<double>& X, const auto&, double dA) {
    if (!facets.is_owned[f]) return;
    for (std::size_t i = 0; i < 3; ++i) sums[i] += X[i] * dA;
    sums[3] += dA;
  });
  sum_in_place(layout.comm, sums);
  SurfaceMean mean;
  mean.area = sums[3];
  if (!(mean.area > 0.0)) return mean;
  mean.middle = (1.0 / mean.area) * Vector3<double>{sums[0], sums[1], sums[2]};

  std::map<PetscInt, NodeOfSurface> nodes;
  std::array<double, 9> moments{};
  for_each_point<Order>(layout, facets, [&](PetscInt f, const Vector3<double>& X, const auto& N, double dA) {
    const Vector3<double> arm = X - mean.middle;
    const auto of_facet = facets.nodes_of(f);
    for (std::size_t a = 0; a < of_facet.size(); ++a) {
      if (of_facet[a] >= layout.num_owned_nodes) continue;
      NodeOfSurface& node = nodes[of_facet[a]];
      node.share += N[a] * dA / mean.area;
      node.moment = node.moment + (N[a] * dA / mean.area) * arm;
    }
    for (std::size_t k = 0; k < 9 && facets.is_owned[f]; ++k) moments[k] += arm[k / 3] * arm[k % 3] * dA / mean.area;
  });
  sum_in_place(layout.comm, moments);
  mean.second_moment = make_tensor([&](int i, int j) { return moments[static_cast<std::size_t>(3 * i + j)]; });
  for (auto& [number, node] : nodes) {
    node.node = number;
    mean.nodes.push_back(node);
  }
  return mean;
}

}  // namespace

// A line has one moment that vanishes, and two that are tr(J).
bool SurfaceMean::is_line() const {
  const double size = trace(second_moment);
  return !(det(rotational_moment()) > narrowest * narrowest * size * size * size);
}

SurfaceMean mean_of_surface(const NodeLayout& layout, const FacetList& facets) {
  return layout.order == 1 ? mean_of<1>(layout, facets) : mean_of<2>(layout, facets);
}

}  // namespace pliant
