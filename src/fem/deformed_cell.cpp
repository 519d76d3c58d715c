#include "fem/deformed_cell.hpp"

#include "base/tensor.hpp"
#include "fem/element.hpp"
#include "fem/quadrature.hpp"
#include "mesh/tetrahedron.hpp"

#include <algorithm>
#include <limits>
#include <vector>

namespace pliant {
namespace {

using tetrahedron::Point;

/// The points at which J is evaluated: on a linear cell it is constant. On a quadratic one it is a cubic, whose minimum
/// is mostly at the corners or inside; the inner points are close to those where laws are evaluated.
template <int Order>
const std::vector<Point>& sample_points() {
  static const std::vector<Point> points = [] {
    if (Order == 1) return std::vector<Point>{{0.25, 0.25, 0.25}};
    std::vector<Point> all{{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}, {0.25, 0.25, 0.25}};
    for (const int degree : {2, 5}) {
      const auto rule = simplex_rule<3>(degree);
      all.insert(all.end(), rule.points.begin(), rule.points.end());
    }
    return all;
  }();
  return points;
}

template <int Order>
double least_volume_ratio(std::span<const Point> X, std::span<const Point> x) {
  double least = std::numeric_limits<double>::infinity();
  for (const Point& xi : sample_points<Order>()) {
    const auto dN = Tet<Order>::gradients(xi);
    Tensor3<double> before{}, now{};
    for (std::size_t a = 0; a < dN.size(); ++a) {
      for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
          before(i, k) += X[a][i] * dN[a][k];
          now(i, k) += x[a][i] * dN[a][k];
        }
      }
    }
    least = std::min(least, det(now) / det(before));
  }
  return least;
}

tetrahedron::Corners corners_of(std::span<const Point> nodes) {
  return {nodes[0], nodes[1], nodes[2], nodes[3]};
}

}  // namespace

DeformedCell deformed_cell(const NodeLayout& layout, PetscInt cell, std::span<const double> u) {
  std::vector<Point> X, x;
  for (const PetscInt n : layout.nodes_of_cell(cell)) {
    X.push_back(layout.position(n));
    x.push_back({X.back()[0] + u[3 * n], X.back()[1] + u[3 * n + 1], X.back()[2] + u[3 * n + 2]});
  }
  DeformedCell shape;
  shape.volume_ratio = layout.order == 1 ? least_volume_ratio<1>(X, x) : least_volume_ratio<2>(X, x);
  shape.quality = tetrahedron::mean_ratio(corners_of(x));
  shape.reference_quality = tetrahedron::mean_ratio(corners_of(X));
  for (std::size_t a = 0; a < 4; ++a) {
    for (std::size_t i = 0; i < 3; ++i) shape.X[i] += X[a][i] / 4.0;
  }
  return shape;
}

}  // namespace pliant
