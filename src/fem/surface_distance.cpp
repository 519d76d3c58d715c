#include "fem/surface_distance.hpp"

#include "fem/nearest_point.hpp"

#include <algorithm>
#include <boost/geometry.hpp>
#include <boost/geometry/index/rtree.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace pliant {
namespace {

namespace bg = boost::geometry;
using BoostPoint = bg::model::point<double, 3, bg::cs::cartesian>;
using BoostBox = bg::model::box<BoostPoint>;
using Leaf = std::pair<BoostBox, std::size_t>;  // of a triangle

class SurfaceDistance final : public SignedDistance {
 public:
  explicit SurfaceDistance(const SurfaceMesh& surface) : surface_(surface) {
    std::vector<Leaf> leaves;
    corner_normals_.resize(surface.nodes.size());
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
      const TrianglePatch corners = patch(t);
      const auto n = cross(corners[1] - corners[0], corners[2] - corners[0]);
      const double size = norm(n);
      normals_.push_back(size > 0.0 ? (1.0 / size) * n : Vector3<double>{});
      BoostBox box;
      bg::assign_inverse(box);
      for (const auto& x : corners) bg::expand(box, BoostPoint(x[0], x[1], x[2]));
      leaves.emplace_back(box, t);
      for (std::size_t a = 0; a < 3; ++a) {
        const auto& [p, q, r] = std::tie(corners[a], corners[(a + 1) % 3], corners[(a + 2) % 3]);
        const auto u = q - p, v = r - p;
        auto& at_corner = corner_normals_[surface.triangles[t][a]];
        at_corner = at_corner + std::atan2(norm(cross(u, v)), dot(u, v)) * normals_.back();
        auto& at_edge = edge_normals_[edge(t, a)];
        at_edge = at_edge + normals_.back();
      }
    }
    tree_ = {leaves.begin(), leaves.end()};
  }

  DistanceAt at(const Vector3<double>& x) const override {
    const auto [triangle, nearest] = find(x);
    const Vector3<double> out = pseudonormal(triangle, nearest), way = x - nearest.point;
    const double length = norm(way), side = dot(way, out) < 0.0 ? -1.0 : 1.0;
    DistanceAt result;
    result.d = side * length;
    if (nearest.feature == Feature::face || length == 0.0) {
      result.n = nearest.feature == Feature::face ? out : (1.0 / norm(out)) * out;
      return result;
    }
    result.n = (side / length) * way;
    Tensor3<double> across = make_tensor([&](int i, int j) { return -result.n[i] * result.n[j]; });
    across = add_to_diagonal(across, 1.0);
    if (nearest.feature == Feature::edge) {
      const TrianglePatch corners = patch(triangle);
      const auto along = corners[(nearest.number + 1) % 3] - corners[nearest.number];
      const double square = dot(along, along);
      across = across - make_tensor([&](int i, int j) { return along[i] * along[j] / square; });
    }
    result.curvature = (side / length) * across;
    return result;
  }

  double distance(const Vector3<double>& x) const override {
    const auto [triangle, nearest] = find(x);
    const Vector3<double> way = x - nearest.point;
    return std::copysign(norm(way), dot(way, pseudonormal(triangle, nearest)));
  }

  std::vector<TrianglePatch> drawing(const Vector3<double>& /*middle*/, double /*extent*/) const override {
    std::vector<TrianglePatch> result;
    for (std::size_t t = 0; t < surface_.triangles.size(); ++t) result.push_back(patch(t));
    return result;
  }

 private:
  using Edge = std::pair<PetscInt, PetscInt>;

  TrianglePatch patch(std::size_t t) const {
    const auto& [a, b, c] = surface_.triangles[t];
    return {surface_.nodes[a], surface_.nodes[b], surface_.nodes[c]};
  }
  Edge edge(std::size_t t, std::size_t a) const {
    const auto& nodes = surface_.triangles[t];
    return std::minmax(nodes[a], nodes[(a + 1) % 3]);
  }

  Vector3<double> pseudonormal(std::size_t t, const Nearest& nearest) const {
    if (nearest.feature == Feature::corner) return corner_normals_[surface_.triangles[t][nearest.number]];
    return nearest.feature == Feature::edge ? edge_normals_.at(edge(t, nearest.number)) : normals_[t];
  }

  /// Boxes come in ascending distance: the search ends when the next one is farther than the nearest triangle so far.
  std::pair<std::size_t, Nearest> find(const Vector3<double>& x) const {
    const BoostPoint point(x[0], x[1], x[2]);
    double least = std::numeric_limits<double>::infinity();
    std::pair<std::size_t, Nearest> best;
    const auto num = static_cast<unsigned>(surface_.triangles.size());
    for (auto leaf = tree_.qbegin(bg::index::nearest(point, num)); leaf != tree_.qend(); ++leaf) {
      if (bg::comparable_distance(point, leaf->first) > least) break;
      const Nearest nearest = nearest_point(patch(leaf->second), x);
      const double square = dot(x - nearest.point, x - nearest.point);
      if (square >= least) continue;
      least = square;
      best = {leaf->second, nearest};
    }
    return best;
  }

  SurfaceMesh surface_;
  std::vector<Vector3<double>> normals_;         // of the triangles
  std::vector<Vector3<double>> corner_normals_;  // weighted by angles, of any length
  std::map<Edge, Vector3<double>> edge_normals_;
  bg::index::rtree<Leaf, bg::index::quadratic<16>> tree_;
};

}  // namespace

std::unique_ptr<SignedDistance> make_distance(const SurfaceMesh& surface) {
  return std::make_unique<SurfaceDistance>(surface);
}

}  // namespace pliant
