#include "mesh/rod_chain.hpp"

#include "base/vector3.hpp"
#include "mesh/chain.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace pliant {
namespace {

using Place = std::array<double, 3>;

/// `up` must be at least so far from a rod's direction, as the sine of the angle between them.
constexpr double nearly_along = 1e-3;
/// A rod that turns back on itself has no curvature: cosine of the angle between two segments.
constexpr double turned_back = -0.999;

/// A direction across the unit vector t.
Vector3<double> any_across(const Vector3<double>& t) {
  std::size_t least = 0;
  for (std::size_t i = 1; i < 3; ++i) {
    if (std::abs(t[i]) < std::abs(t[least])) least = i;
  }
  Vector3<double> other{};
  other[least] = 1.0;
  return unit(cross(t, other));
}

/// The parallel transport of d, across s, from the unit vector s to t.
Vector3<double> transported(const Vector3<double>& d, const Vector3<double>& s, const Vector3<double>& t) {
  const Vector3<double> along = d - (dot(d, t) / (1.0 + dot(s, t))) * (s + t);
  return unit(along - dot(along, t) * t);
}

CornerPlaces corners(const Vector3<double>& from, const Vector3<double>& to, const Vector3<double>& middle,
                     const Vector3<double>& arm_1, const Vector3<double>& arm_2) {
  return {from, to, middle + arm_1, middle + arm_2};
}

}  // namespace

RodChain rod_chain(const AddedRod& rod, std::span<const Place> points) {
  RodChain chain;
  Vector3<double> t{}, d{};
  for (std::size_t k = 1; k < points.size(); ++k) {
    const Vector3<double> from = points[k - 1], to = points[k], before = t;
    const double length = norm(to - from);
    if (!(length > 0.0)) {
      chain.fault = fmt::format("has the point ({:g}, {:g}, {:g}) twice in a row", from[0], from[1], from[2]);
      return chain;
    }
    t = (1.0 / length) * (to - from);
    if (k > 1 && dot(before, t) < turned_back) {
      chain.fault = fmt::format("turns back on itself at ({:g}, {:g}, {:g})", from[0], from[1], from[2]);
      return chain;
    }
    if (rod.up) {
      const Vector3<double> up = unit(Vector3<double>(*rod.up)), across = up - dot(up, t) * t;
      if (norm(across) < nearly_along) {
        chain.fault = fmt::format("is parallel to its `up` at ({:g}, {:g}, {:g}): choose a direction across it",
                                  from[0], from[1], from[2]);
        return chain;
      }
      d = unit(across);
    } else {
      d = k == 1 ? any_across(t) : transported(d, before, t);
    }
    const Vector3<double> arm_1 = rod.arms[0] * d, arm_2 = rod.arms[1] * cross(t, d);
    chain.segments.push_back(corners(from, to, 0.5 * (from + to), arm_1, arm_2));
    const Vector3<double> beyond = (0.5 * length) * t;
    if (k == 1 && rod.has_end[0]) chain.ends[0] = corners(from - beyond, from, from, arm_1, arm_2);
    if (k + 1 == points.size() && rod.has_end[1]) chain.ends[1] = corners(to, to + beyond, to, arm_1, arm_2);
  }
  return chain;
}

std::vector<Place> points_of(const AddedRod& rod, std::span<const MeshCurve> curves) {
  if (rod.curve.empty()) return rod.points;
  const auto is_it = [&](const MeshCurve& curve) {
    return curve.group.name == rod.curve || std::to_string(curve.group.tag) == rod.curve;
  };
  const auto found = std::ranges::find_if(curves, is_it);
  if (found == curves.end() || found->edges.empty()) {
    throw InputError(rod.where,
                     fmt::format("the mesh has no physical curve '{}', which rod '{}' follows", rod.curve, rod.name));
  }
  Chain chain = chain_of(found->edges, "a rod");
  if (!chain.fault.empty()) {
    throw InputError(rod.where,
                     fmt::format("physical curve '{}', which rod '{}' follows, {}", rod.curve, rod.name, chain.fault));
  }
  return std::move(chain.points);
}

std::string name_of_end(const std::string& rod, std::size_t end) {
  return rod + (end == 0 ? "_start" : "_end");
}

}  // namespace pliant
