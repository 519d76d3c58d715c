#include "energy/contact/passage.hpp"

#include "energy/contact/body_surfaces.hpp"
#include "fem/element.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace pliant {
namespace {

/// The least advance along a path, relative to its length: a thinner solid is not detected.
constexpr double least_advance = 1e-3;
/// By how much a point half as deep again must be less deep.
constexpr double clearly = 0.05;

/// How close to each other, relative to the obstacle's width, facets are examined, and into how many parts edges are
/// divided at most.
constexpr double parts_of_width = 4.0, max_parts = 32.0;

Vector3<double> place_on(const ContactSurface& surface, std::span<const PetscInt> nodes,
                         const std::array<double, 2>& xi, std::span<const double> q) {
  Vector3<double> x{};
  const auto add = [&](const auto& N) {
    for (std::size_t a = 0; a < N.size(); ++a) x = x + N[a] * surface.position(nodes[a], q);
  };
  if (nodes.size() == 3 || is_segment(nodes)) {
    add(Triangle<1>::values(xi));
  } else {
    add(Triangle<2>::values(xi));
  }
  return x;
}

bool lies_beyond_the_middle(const SignedDistance& solid, const Vector3<double>& x, const DistanceAt& at) {
  return solid.distance(x + 0.5 * at.d * at.n) > (1.0 - clearly) * at.d;
}

}  // namespace

Closeness closeness(const ContactSurface& surface, const ObstacleFrame& obstacle, std::span<const double> q) {
  Closeness result;
  const NormalLaw& law = surface.law();
  const auto& is_owned = surface.facets().is_owned;
  for (PetscInt f = 0; f < surface.facets().size(); ++f) {
    if (!is_owned[f]) continue;
    const auto [centre, radius] = surface.ball(f, q);
    if (obstacle.distance(centre) - radius > std::max(law.reach(), law.threshold + result.gap)) continue;
    surface.for_each_of(f, [&](const ContactSurface::Point& point) {
      const double d = obstacle.distance(surface.position(point, q));
      result.gap = std::min(result.gap, d - law.threshold);
      if (d < law.reach()) result.num_points += 1.0;
    });
    for (const PetscInt node : surface.nodes_of(f)) {
      result.gap = std::min(result.gap, obstacle.distance(surface.position(node, q)) - law.threshold);
    }
  }
  return result;
}

std::optional<Passage> passage(const SignedDistance& solid, const Vector3<double>& from, const Vector3<double>& to) {
  const Vector3<double> way = to - from;
  const double length = norm(way);
  double d = solid.distance(from);
  if (!(d < length)) return std::nullopt;
  bool is_inside = d < 0.0;
  Vector3<double> entry{};
  if (is_inside) entry = solid.at(from).n;
  double depth = std::max(0.0, -d), travelled = 0.0;
  // The distance is a lower bound of the distance to the surface, outside as well as inside.
  while (travelled < 1.0) {
    travelled = std::min(1.0, travelled + std::max(least_advance, std::abs(d) / length));
    const Vector3<double> x = from + travelled * way;
    d = solid.distance(x);
    if (d >= 0.0 && !is_inside) continue;
    const DistanceAt at = solid.at(x);
    if (!is_inside) {
      is_inside = true;
      entry = at.n;
      depth = 0.0;
    }
    depth = std::max(depth, -d);
    const bool has_passed = dot(entry, at.n) < 0.0;
    if (d >= 0.0) {
      if (has_passed) return Passage{depth, to};
      is_inside = false;  // it cut a corner, or was pushed out
    } else if (travelled == 1.0 && (has_passed || lies_beyond_the_middle(solid, x, at))) {
      return Passage{depth, to};
    }
  }
  return std::nullopt;
}

std::optional<Passage> passage(const ContactSurface& surface, const ObstacleStep& step, std::span<const double> q_from,
                               std::span<const double> q_to) {
  std::optional<Passage> deepest;
  const auto look_at = [&](const Vector3<double>& x_from, const Vector3<double>& x_to) {
    const auto found = passage(step.shape, step.from.in_shape(x_from), step.to.in_shape(x_to));
    if (found && (!deepest || found->depth > deepest->depth)) deepest = Passage{found->depth, x_to};
  };
  for (PetscInt f = 0; f < surface.facets().size(); ++f) {
    if (!surface.facets().is_owned[f]) continue;
    const auto nodes = surface.nodes_of(f);
    double way = 0.0;
    for (const PetscInt node : nodes) {
      way = std::max(way, norm(step.to.in_shape(surface.position(node, q_to)) -
                               step.from.in_shape(surface.position(node, q_from))));
    }
    const auto [centre, radius] = surface.ball(f, q_from);
    if (step.from.distance(centre) - radius > surface.overshoot() * way) continue;
    surface.for_each_of(f, [&](const ContactSurface::Point& point) {
      look_at(surface.position(point, q_from), surface.position(point, q_to));
    });
    const double parts = std::ceil(parts_of_width * 2.0 * radius / step.width);
    const int n = static_cast<int>(std::clamp(parts, 1.0, max_parts));
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; i + j <= n; ++j) {
        const std::array xi{static_cast<double>(i) / n, static_cast<double>(j) / n};
        look_at(place_on(surface, nodes, xi, q_from), place_on(surface, nodes, xi, q_to));
      }
    }
  }
  return deepest;
}

}  // namespace pliant
