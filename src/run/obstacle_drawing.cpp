#include "run/obstacle_drawing.hpp"

#include "petsc/collective.hpp"

#include <algorithm>
#include <limits>
#include <map>

namespace pliant {
namespace {

/// The extent to which unbounded obstacles are drawn, in half diagonals of the bodies' bounding box.
constexpr double drawn_half_diagonals = 3.0;

struct Around {
  Vector3<double> middle{};
  double half_diagonal = 0.0;  ///< [m]
};

/// Collective.
Around box_around(const NodeLayout& layout) {
  Vector3<double> lower, upper;
  lower.fill(std::numeric_limits<double>::infinity());
  upper.fill(-std::numeric_limits<double>::infinity());
  for (PetscInt a = 0; a < layout.num_owned_nodes; ++a) {
    const Vector3<double> X = layout.position(a);
    for (std::size_t i = 0; i < 3; ++i) {
      lower[i] = std::min(lower[i], X[i]);
      upper[i] = std::max(upper[i], X[i]);
    }
  }
  for (double& x : lower) x = minimum(layout.comm, x);
  for (double& x : upper) x = maximum(layout.comm, x);
  return {0.5 * (lower + upper), 0.5 * norm(upper - lower)};
}

}  // namespace

ObstacleDrawing::ObstacleDrawing(const Contacts& contacts, const NodeLayout& layout) : contacts_(contacts) {
  const Around bodies = box_around(layout);
  const auto obstacles = contacts.obstacles();
  for (std::size_t k = 0; k < obstacles.size(); ++k) {
    surfaces_.names.push_back(contacts.groups()[k].name);
    std::map<Vector3<double>, std::int64_t> number_of;
    for (const TrianglePatch& triangle :
         obstacles[k]->shape().drawing(bodies.middle, drawn_half_diagonals * bodies.half_diagonal)) {
      for (const Vector3<double>& X : triangle) {
        const auto [point, is_new] = number_of.insert({X, std::ssize(surfaces_.points) / 3});
        if (is_new) surfaces_.points.insert(surfaces_.points.end(), X.begin(), X.end());
        surfaces_.triangles.push_back(point->second);
      }
      surfaces_.obstacles.push_back(static_cast<std::int32_t>(k));
    }
    end_of_points_.push_back(surfaces_.points.size());
  }
}

std::vector<double> ObstacleDrawing::points(const Instant& at) const {
  const auto obstacles = contacts_.obstacles();
  if (std::ranges::none_of(obstacles, [](const auto& obstacle) { return obstacle->moves(); })) return {};
  std::vector<double> result;
  result.reserve(surfaces_.points.size());
  for (std::size_t k = 0; k < obstacles.size(); ++k) {
    const ObstacleFrame frame = obstacles[k]->at(at);
    while (result.size() < end_of_points_[k]) {
      const double* X = &surfaces_.points[result.size()];
      const Vector3<double> x = frame.place({X[0], X[1], X[2]});
      result.insert(result.end(), x.begin(), x.end());
    }
  }
  return result;
}

}  // namespace pliant
