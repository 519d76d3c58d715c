#include "energy/constraint/facet_projection.hpp"

#include "collision/closest_points.hpp"
#include "fem/element.hpp"
#include "fem/quadrature.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace pliant {
namespace {

/// A mid-edge node this close to the middle of its edge, relative to the edge, does not curve it.
constexpr double straight = 1e-10;
/// Relative to the size of the surface: distances that differ by less are the same.
constexpr double same_distance = 1e-10;
/// Cosine of the steepest angle between facets that face each other.
constexpr double least_cosine = 0.3;
/// A projection needs at least this fraction of its facet.
constexpr double least_coverage = 0.5;

bool is_curved_facet(std::span<const Vector3<double>> nodes) {
  for (std::size_t e = 0; e + 3 < nodes.size(); ++e) {
    const auto [i, j] = triangle_edges[e];
    const Vector3<double> middle = 0.5 * (nodes[i] + nodes[j]);
    if (norm(nodes[e + 3] - middle) > straight * norm(nodes[i] - nodes[j])) return true;
  }
  return false;
}

/// Local nodes of a facet of a cell: corners, then mid-edge nodes.
std::vector<int> facet_nodes(const FacetOfCell& facet) {
  std::vector<int> result;
  for (int a = 0; a < 4; ++a) {
    if (a != facet.opposite) result.push_back(a);
  }
  if (facet.nodes_per_cell == 4) return result;
  for (const auto& [i, j] : triangle_edges) {
    for (std::size_t e = 0; e < tet_edges.size(); ++e) {
      const auto [a, b] = tet_edges[e];
      if (std::min(result[i], result[j]) == std::min(a, b) && std::max(result[i], result[j]) == std::max(a, b)) {
        result.push_back(4 + static_cast<int>(e));
      }
    }
  }
  return result;
}

std::array<Vector3<double>, 3> sorted_corners(const FacetOfCell& facet) {
  std::array<Vector3<double>, 3> corners{};
  const std::vector<int> nodes = facet_nodes(facet);
  for (std::size_t k = 0; k < 3; ++k) corners[k] = facet.positions[static_cast<std::size_t>(nodes[k])];
  std::ranges::sort(corners);
  return corners;
}

std::array<double, 10> shapes_at(int nodes_per_cell, const std::array<double, 3>& xi) {
  std::array<double, 10> result{};
  if (nodes_per_cell == 4) {
    std::ranges::copy(Tet<1>::values(xi), result.begin());
  } else {
    std::ranges::copy(Tet<2>::values(xi), result.begin());
  }
  return result;
}

/// sum_j N_j X_j.
Vector3<double> interpolated(std::span<const double> N, std::span<const Vector3<double>> X) {
  Vector3<double> sum{};
  for (std::size_t j = 0; j < X.size(); ++j) sum = sum + N[j] * X[j];
  return sum;
}

/// The columns dX/dxi.
std::array<Vector3<double>, 3> tangents(const FacetOfCell& facet, const std::array<double, 3>& xi) {
  std::array<Vector3<double>, 3> result{};
  const auto add = [&](const auto& gradients) {
    for (std::size_t j = 0; j < gradients.size(); ++j) {
      for (std::size_t k = 0; k < 3; ++k) result[k] = result[k] + gradients[j][k] * facet.positions[j];
    }
  };
  if (facet.nodes_per_cell == 4) {
    add(Tet<1>::gradients(xi));
  } else {
    add(Tet<2>::gradients(xi));
  }
  return result;
}

/// Where X lies on the reference tetrahedron of the cell, or outside of it: Newton's method, of one step for a straight
/// cell and one against rounding.
std::array<double, 3> reference_point(const FacetOfCell& facet, const Vector3<double>& X) {
  constexpr int most_iterations = 20;
  std::array<double, 3> xi{0.25, 0.25, 0.25}, best = xi;
  double least = std::numeric_limits<double>::infinity();
  const std::span positions(facet.positions.data(), static_cast<std::size_t>(facet.nodes_per_cell));
  for (int i = 0; i < most_iterations; ++i) {
    const Vector3<double> missing = X - interpolated(shapes_at(facet.nodes_per_cell, xi), positions);
    const double error = norm(missing);
    if (!(error < 0.5 * least)) {
      if (error < least) best = xi;
      break;
    }
    least = error;
    best = xi;
    const auto [a, b, c] = tangents(facet, xi);
    const double volume = dot(a, cross(b, c));
    xi[0] += dot(missing, cross(b, c)) / volume;
    xi[1] += dot(missing, cross(c, a)) / volume;
    xi[2] += dot(missing, cross(a, b)) / volume;
  }
  return best;
}

/// p = M^-1 b by Cholesky's factorization, for all right-hand sides in place; M is symmetric, of the size of the b.
template <class RightHandSides>
void solve_by_cholesky(std::array<std::array<double, 6>, 6>& M, std::size_t n, RightHandSides& all) {
  for (std::size_t j = 0; j < n; ++j) {
    for (std::size_t k = 0; k < j; ++k) M[j][j] -= M[j][k] * M[j][k];
    M[j][j] = std::sqrt(M[j][j]);
    for (std::size_t i = j + 1; i < n; ++i) {
      for (std::size_t k = 0; k < j; ++k) M[i][j] -= M[i][k] * M[j][k];
      M[i][j] /= M[j][j];
    }
  }
  for (auto& [node, b] : all) {
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t k = 0; k < i; ++k) b[i] -= M[i][k] * b[k];
      b[i] /= M[i][i];
    }
    for (std::size_t i = n; i-- > 0;) {
      for (std::size_t k = i + 1; k < n; ++k) b[i] -= M[k][i] * b[k];
      b[i] /= M[i][i];
    }
  }
}

/// The integrals over a facet, summed point by point.
class Projector {
 public:
  Projector(std::span<const Vector3<double>> nodes, const IndependentSurface& onto, double tolerance)
      : nodes_(nodes), onto_(onto), tolerance_(tolerance), tiles_(tiles_of(nodes)) {
    const bool is_flat = tiles_.size() == 1 && !onto.is_curved();
    const int order = nodes.size() == 3 ? 1 : 2;
    rule_ = simplex_rule<2>(is_flat ? 2 * order : 2 * order + 2);
  }

  std::optional<FacetProjection> operator()() {
    FacetProjection result;
    for (const FacetTile& tile : tiles_) {
      const auto& [a, b, c] = tile.corners;
      result.area += 0.5 * norm(cross(b - a, c - a));
      add(tile);
    }
    if (covered_ < least_coverage * whole_) return std::nullopt;
    solve_by_cholesky(mass_, nodes_.size(), right_);
    result.weights.resize(nodes_.size());
    for (const auto& [node, p] : right_) {
      for (std::size_t k = 0; k < nodes_.size(); ++k) result.weights[k].push_back({node, p[k]});
    }
    return result;
  }

 private:
  // In coordinates in which the tile is the reference triangle.
  void add(const FacetTile& tile) {
    const auto& [a, b, c] = tile.corners;
    const Vector3<double> normal = cross(b - a, c - a);
    const double square = dot(normal, normal);
    const auto flattened = [&](const Vector3<double>& X) {
      return PlanePoint{dot(cross(X - a, c - a), normal) / square, dot(cross(b - a, X - a), normal) / square};
    };
    struct Candidate {
      std::int32_t tile;
      bool faces;  // has the opposite normal, and comes first
      std::array<PlanePoint, 3> corners;
    };
    std::vector<Candidate> candidates;
    for (const std::int32_t t : onto_.tiles_near(tile, tolerance_)) {
      const auto& [x, y, z] = onto_.tile(t).corners;
      const Vector3<double> other = cross(y - x, z - x);
      const double cosine = dot(normal, other) / (norm(normal) * norm(other));
      if (std::abs(cosine) < least_cosine || !is_near(tile, onto_.tile(t).corners)) continue;
      Candidate candidate{t, cosine < 0.0, {flattened(x), flattened(y), flattened(z)}};
      if (candidate.faces) std::swap(candidate.corners[1], candidate.corners[2]);
      candidates.push_back(candidate);
    }
    std::ranges::stable_partition(candidates, &Candidate::faces);
    std::vector<Polygon> uncovered{{{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}}};
    for (const Candidate& candidate : candidates) {
      std::vector<Polygon> covered;
      cover(candidate.corners, uncovered, covered);
      for (const Polygon& polygon : covered) add(tile, polygon, onto_.tile(candidate.tile).facet);
    }
    for (const Polygon& polygon : uncovered) add(tile, polygon, std::nullopt);
  }

  /// Whether the triangle reaches into the layer of the tolerance along the tile.
  bool is_near(const FacetTile& tile, const std::array<Vector3<double>, 3>& triangle) const {
    const auto& [a, b, c] = tile.corners;
    const Vector3<double> normal = unit(cross(b - a, c - a));
    const std::array heights{dot(triangle[0] - a, normal), dot(triangle[1] - a, normal), dot(triangle[2] - a, normal)};
    return std::ranges::min(heights) <= tolerance_ && std::ranges::max(heights) >= -tolerance_;
  }

  /// A part of the tile, before this facet or before the nearest one of each point.
  void add(const FacetTile& tile, const Polygon& polygon, std::optional<std::size_t> facet) {
    for (std::size_t k = 2; k < polygon.size(); ++k) {
      const std::array corners{polygon[0], polygon[k - 1], polygon[k]};
      const double doubled = doubled_area(corners[0], corners[1], corners[2]);
      for (int q = 0; q < rule_.size(); ++q) {
        const PlanePoint at = on_triangle(corners, rule_.points[static_cast<std::size_t>(q)]);
        add(on_triangle(tile.xi, at), doubled * rule_.weights[static_cast<std::size_t>(q)], facet);
      }
    }
  }

  static PlanePoint on_triangle(const std::array<PlanePoint, 3>& x, const PlanePoint& s) {
    const double r = 1.0 - s[0] - s[1];
    return {r * x[0][0] + s[0] * x[1][0] + s[1] * x[2][0], r * x[0][1] + s[0] * x[1][1] + s[1] * x[2][1]};
  }

  void add(const PlanePoint& xi, double weight, std::optional<std::size_t> facet) {
    std::array<double, 6> phi{};
    if (nodes_.size() == 3) {
      std::ranges::copy(Triangle<1>::values(xi), phi.begin());
    } else {
      std::ranges::copy(Triangle<2>::values(xi), phi.begin());
    }
    const Vector3<double> X = interpolated(phi, nodes_);
    whole_ += weight;
    if (!facet) {
      const auto nearest = onto_.nearest(X, tolerance_);
      if (!nearest) return;
      facet = nearest->facet;
    }
    covered_ += weight;
    const FacetOfCell& cell = onto_.facet(*facet);
    const auto N = onto_.shape_functions(*facet, X);
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      for (std::size_t l = 0; l < nodes_.size(); ++l) mass_[k][l] += weight * phi[k] * phi[l];
      for (std::size_t j = 0; j < static_cast<std::size_t>(cell.nodes_per_cell); ++j) {
        right_[cell.nodes[j]][k] += weight * phi[k] * N[j];
      }
    }
  }

  std::span<const Vector3<double>> nodes_;
  const IndependentSurface& onto_;
  double tolerance_;
  std::vector<FacetTile> tiles_;
  QuadratureRule<2> rule_;
  double whole_ = 0.0, covered_ = 0.0;
  std::array<std::array<double, 6>, 6> mass_{};
  std::map<PetscInt, std::array<double, 6>> right_;
};

}  // namespace

std::vector<FacetTile> tiles_of(std::span<const Vector3<double>> nodes) {
  constexpr std::array<PlanePoint, 6> xi{{{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}, {0.5, 0.0}, {0.5, 0.5}, {0.0, 0.5}}};
  const auto tile = [&](std::size_t a, std::size_t b, std::size_t c) {
    return FacetTile{{nodes[a], nodes[b], nodes[c]}, {xi[a], xi[b], xi[c]}};
  };
  if (!is_curved_facet(nodes)) return {tile(0, 1, 2)};
  return {tile(0, 3, 5), tile(3, 1, 4), tile(5, 4, 2), tile(3, 4, 5)};
}

IndependentSurface::IndependentSurface(std::vector<FacetOfCell> facets) : facets_(std::move(facets)) {
  std::ranges::sort(facets_, {}, sorted_corners);
  std::vector<Box> boxes;
  Vector3<double> low = facets_.front().positions[0], high = low;
  for (std::size_t f = 0; f < facets_.size(); ++f) {
    std::vector<Vector3<double>> nodes;
    for (const int a : facet_nodes(facets_[f])) nodes.push_back(facets_[f].positions[static_cast<std::size_t>(a)]);
    for (const Vector3<double>& X : nodes) {
      for (std::size_t i = 0; i < 3; ++i) {
        low[i] = std::min(low[i], X[i]);
        high[i] = std::max(high[i], X[i]);
      }
    }
    double bulge = 0.0;  // of the curved facet beyond its tiles, at most
    for (std::size_t e = 0; e + 3 < nodes.size(); ++e) {
      const auto [i, j] = triangle_edges[e];
      bulge = std::max(bulge, norm(nodes[e + 3] - 0.5 * (nodes[i] + nodes[j])));
    }
    for (const FacetTile& tile : tiles_of(nodes)) {
      tiles_.push_back({tile.corners, f});
      boxes.push_back(box_of(bulge, tile.corners[0], tile.corners[1], tile.corners[2]));
    }
  }
  size_ = norm(high - low);
  tree_ = Bvh(boxes);
}

std::array<double, 10> IndependentSurface::shape_functions(std::size_t facet, const Vector3<double>& X) const {
  return shapes_at(facets_[facet].nodes_per_cell, reference_point(facets_[facet], X));
}

// A flat facet has the distance of its triangle, a curved one that of its point with the same coordinates as X, if
// there is such a point.
double IndependentSurface::distance(std::size_t tile, const Vector3<double>& X) const {
  const Tile& t = tiles_[tile];
  const std::array<Vector3<double>, 4> points{X, t.corners[0], t.corners[1], t.corners[2]};
  const double to_tile = std::sqrt(closest_point_triangle(points).squared_distance);
  if (!is_curved()) return to_tile;
  const FacetOfCell& facet = facets_[t.facet];
  const auto xi = reference_point(facet, X);
  std::array<double, 4> l{1.0 - xi[0] - xi[1] - xi[2], xi[0], xi[1], xi[2]};
  const auto opposite = static_cast<std::size_t>(facet.opposite);
  const double height = l[opposite];
  for (double& coordinate : l) coordinate += height / 3.0;
  l[opposite] = 0.0;
  if (*std::ranges::min_element(l) < -same_distance) return to_tile;
  const Vector3<double> foot =
      interpolated(shapes_at(facet.nodes_per_cell, {l[1], l[2], l[3]}),
                   std::span(facet.positions.data(), static_cast<std::size_t>(facet.nodes_per_cell)));
  return std::min(to_tile, norm(X - foot));
}

std::optional<IndependentSurface::Place> IndependentSurface::nearest(const Vector3<double>& X, double reach) const {
  std::vector<std::int32_t> near;
  tree_.for_each_overlap(box_of(reach, X), [&](std::int32_t t) { near.push_back(t); });
  std::ranges::sort(near);
  std::optional<Place> best;
  for (const std::int32_t t : near) {
    const double d = distance(static_cast<std::size_t>(t), X);
    if (d <= reach && (!best || d < best->distance - same_distance * size_)) best = {tile(t).facet, d};
  }
  return best;
}

double IndependentSurface::distance(const Vector3<double>& X) const {
  double reach = 0.01 * size_;
  for (;; reach *= 2.0) {
    if (const auto place = nearest(X, reach)) return place->distance;
  }
}

std::vector<std::int32_t> IndependentSurface::tiles_near(const FacetTile& tile, double reach) const {
  std::vector<std::int32_t> result;
  const Box box = box_of(reach, tile.corners[0], tile.corners[1], tile.corners[2]);
  tree_.for_each_overlap(box, [&](std::int32_t t) { result.push_back(t); });
  std::ranges::sort(result);
  return result;
}

std::optional<FacetProjection> project(std::span<const Vector3<double>> nodes, const IndependentSurface& onto,
                                       double tolerance) {
  return Projector(nodes, onto, tolerance)();
}

}  // namespace pliant
