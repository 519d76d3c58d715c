#include "fem/cell_integration.hpp"

#include "base/vector3.hpp"
#include "fem/element.hpp"
#include "fem/quadrature.hpp"

#include <algorithm>
#include <map>

namespace pliant {
namespace {

/// Degrees of the squares of shape functions; on curved cells the volumes of points count too.
constexpr std::array<int, 3> degree_of_squares{0, 2, 5};

template <int Dim>
const QuadratureRule<Dim>& rule_of(int order) {
  static const std::array<QuadratureRule<Dim>, 3> rules{simplex_rule<Dim>(degree_of_squares[0]),
                                                        simplex_rule<Dim>(degree_of_squares[1]),
                                                        simplex_rule<Dim>(degree_of_squares[2])};
  return rules[static_cast<std::size_t>(order)];
}

/// sum_a f_a (x) g_a, with f_a three numbers of the node.
template <int Order>
Tensor3<double> nodal_product(std::span<const double> f, std::span<const PetscInt> nodes,
                              const std::array<std::array<double, 3>, Tet<Order>::num_nodes>& g) {
  Tensor3<double> result{};
  // From differences to the first node: common parts cancel before they are multiplied.
  for (std::size_t a = 1; a < g.size(); ++a) {
    for (int i = 0; i < 3; ++i) {
      const double d = f[3 * nodes[a] + i] - f[3 * nodes[0] + i];
      for (int k = 0; k < 3; ++k) result(i, k) += d * g[a][k];
    }
  }
  return result;
}

template <int Order>
void visit_cell(const NodeLayout& layout, PetscInt cell, const std::function<void(const IntegrationPoint&)>& visit) {
  const QuadratureRule<3>& rule = rule_of<3>(Order);
  const auto nodes = layout.nodes_of_cell(cell);
  for (int k = 0; k < rule.size(); ++k) {
    const auto& xi = rule.points[k];
    const auto N = Tet<Order>::values(xi);
    const double jacobian = det(nodal_product<Order>(layout.coordinates, nodes, Tet<Order>::gradients(xi)));
    visit({rule.weights[k] * jacobian, N, xi});
  }
}

template <int Order>
void visit_facet(const NodeLayout& layout, std::span<const PetscInt> nodes,
                 const std::function<void(const IntegrationPoint&)>& visit) {
  const QuadratureRule<2>& rule = rule_of<2>(Order);
  for (int k = 0; k < rule.size(); ++k) {
    const auto& xi = rule.points[k];
    const auto N = Triangle<Order>::values(xi);
    const auto dN = Triangle<Order>::gradients(xi);
    std::array<Vector3<double>, 2> tangents{};
    for (std::size_t a = 0; a < dN.size(); ++a) {
      for (std::size_t i = 0; i < 2; ++i) tangents[i] = tangents[i] + dN[a][i] * layout.position(nodes[a]);
    }
    visit({rule.weights[k] * norm(cross(tangents[0], tangents[1])), N});
  }
}

template <int Order>
Tensor3<double> gradient_at(const NodeLayout& layout, PetscInt cell, const std::array<double, 3>& xi,
                            std::span<const double> u) {
  const auto nodes = layout.nodes_of_cell(cell);
  const auto dN = Tet<Order>::gradients(xi);
  const Tensor3<double> j = nodal_product<Order>(layout.coordinates, nodes, dN);
  const Tensor3<double> inverse = (1.0 / det(j)) * transpose(cofactor(j));
  return matmul(nodal_product<Order>(u, nodes, dN), inverse);
}

template <int Order>
std::array<double, 3> position_at(const NodeLayout& layout, PetscInt cell, const std::array<double, 3>& xi) {
  const auto nodes = layout.nodes_of_cell(cell);
  const auto N = Tet<Order>::values(xi);
  Vector3<double> X{};
  for (std::size_t a = 0; a < N.size(); ++a) X = X + N[a] * layout.position(nodes[a]);
  return X;
}

}  // namespace

void for_each_point_of_cell(const NodeLayout& layout, PetscInt cell,
                            const std::function<void(const IntegrationPoint&)>& visit) {
  layout.order == 1 ? visit_cell<1>(layout, cell, visit) : visit_cell<2>(layout, cell, visit);
}

void for_each_point_of_facet(const NodeLayout& layout, std::span<const PetscInt> nodes,
                             const std::function<void(const IntegrationPoint&)>& visit) {
  layout.order == 1 ? visit_facet<1>(layout, nodes, visit) : visit_facet<2>(layout, nodes, visit);
}

std::array<double, 3> position_in_cell(const NodeLayout& layout, PetscInt cell, const std::array<double, 3>& xi) {
  return layout.order == 1 ? position_at<1>(layout, cell, xi) : position_at<2>(layout, cell, xi);
}

Tensor3<double> gradient_in_cell(const NodeLayout& layout, PetscInt cell, const std::array<double, 3>& xi,
                                 std::span<const double> u) {
  return layout.order == 1 ? gradient_at<1>(layout, cell, xi, u) : gradient_at<2>(layout, cell, xi, u);
}

std::vector<std::array<PetscInt, 2>> cells_of_facets(const NodeLayout& layout, std::span<const PetscInt> facet_nodes,
                                                     int nodes_per_facet) {
  using Corners = std::array<PetscInt, 3>;
  const auto sorted = [](Corners corners) {
    std::ranges::sort(corners);
    return corners;
  };
  std::map<Corners, std::size_t> number;
  const auto width = static_cast<std::size_t>(nodes_per_facet);
  const std::size_t count = facet_nodes.size() / width;
  for (std::size_t f = 0; f < count; ++f) {
    const PetscInt* nodes = &facet_nodes[width * f];
    number[sorted({nodes[0], nodes[1], nodes[2]})] = f;
  }
  std::vector<std::array<PetscInt, 2>> cells(count, {-1, -1});
  if (count == 0) return cells;
  for (PetscInt cell = 0; cell < layout.num_local_cells; ++cell) {
    const auto nodes = layout.nodes_of_cell(cell);
    for (std::size_t off = 0; off < 4; ++off) {
      const auto found = number.find(sorted({nodes[(off + 1) % 4], nodes[(off + 2) % 4], nodes[(off + 3) % 4]}));
      if (found == number.end()) continue;
      auto& sides = cells[found->second];
      (sides[0] < 0 ? sides[0] : sides[1]) = cell;
    }
  }
  return cells;
}

}  // namespace pliant
