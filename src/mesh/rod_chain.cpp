#include "mesh/rod_chain.hpp"

#include "base/vector3.hpp"
#include "mesh/chain.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <fmt/format.h>

namespace pliant {
namespace {

using Place = std::array<double, 3>;

/// `up` must be at least so far from a rod's direction, as the sine of the angle between them.
constexpr double nearly_along = 1e-3;
/// A rod that turns back on itself has no curvature: cosine of the angle between two segments.
constexpr double turned_back = -0.999;
/// Points of rods are one if they lie closer than this part of the shortest segment at either.
constexpr double same_point = 1e-6;

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

/// Points of rods, and which of them are near a place.
class KnownPoints {
 public:
  /// `widest`: more than any reach [m].
  explicit KnownPoints(double widest) : widest_(widest) {}

  /// The point that is this one within both reaches; nullptr if none is.
  const Place* find(const Place& x, double reach) const {
    const Place* found = nullptr;
    double least = 0.0;
    const Place home = box_of(x);
    for (std::size_t near = 0; near < 27; ++near) {
      const auto off = [&](std::size_t i) { return static_cast<double>(i % 3) - 1.0; };
      const auto [first, last] =
          points_.equal_range({home[0] + off(near), home[1] + off(near / 3), home[2] + off(near / 9)});
      for (auto point = first; point != last; ++point) {
        const double distance = norm(Vector3<double>(x) - point->second.place);
        if (distance > std::min(reach, point->second.reach) || (found != nullptr && distance >= least)) continue;
        found = &point->second.place;
        least = distance;
      }
    }
    return found;
  }
  void add(const Place& x, double reach) { points_.emplace(box_of(x), Known{x, reach}); }

 private:
  struct Known {
    Place place{};
    double reach = 0.0;
  };
  Place box_of(const Place& x) const {
    return {std::floor(x[0] / widest_), std::floor(x[1] / widest_), std::floor(x[2] / widest_)};
  }

  double widest_;
  std::multimap<Place, Known> points_;  // by boxes
};

/// How far around each point of a chain another one is the same [m].
std::vector<double> reaches_of(std::span<const Place> points) {
  std::vector<double> reaches(points.size(), std::numeric_limits<double>::infinity());
  for (std::size_t k = 1; k < points.size(); ++k) {
    const double reach = same_point * norm(Vector3<double>(points[k]) - Vector3<double>(points[k - 1]));
    for (const std::size_t end : {k - 1, k}) reaches[end] = std::min(reaches[end], reach);
  }
  return reaches;
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
    throw InputError(rod.where, fmt::format("the mesh has no {} '{}', which rod '{}' follows",
                                            found == curves.end() ? "physical curve" : "edges of physical curve",
                                            rod.curve, rod.name));
  }
  Chain chain = chain_of(found->edges, "a rod");
  if (!chain.fault.empty()) {
    throw InputError(rod.where,
                     fmt::format("physical curve '{}', which rod '{}' follows, {}", rod.curve, rod.name, chain.fault));
  }
  return std::move(chain.points);
}

std::vector<std::vector<Place>> joined_points_of(std::span<const AddedRod> rods, std::span<const MeshCurve> curves) {
  std::vector<std::vector<Place>> result;
  std::vector<std::vector<double>> reaches;
  double widest = std::numeric_limits<double>::min();
  for (const AddedRod& rod : rods) {
    result.push_back(points_of(rod, curves));
    reaches.push_back(reaches_of(result.back()));
    for (const double reach : reaches.back()) widest = std::isfinite(reach) ? std::max(widest, 2.0 * reach) : widest;
  }
  KnownPoints known(widest);
  for (const bool is_curve : {true, false}) {
    for (std::size_t r = 0; r < rods.size(); ++r) {
      if (rods[r].curve.empty() == is_curve) continue;
      for (std::size_t k = 0; k < result[r].size(); ++k) {
        Place& x = result[r][k];
        const Place* same = is_curve ? nullptr : known.find(x, reaches[r][k]);
        if (same != nullptr) x = *same;
        known.add(x, reaches[r][k]);
      }
    }
  }
  return result;
}

std::string name_of_end(const std::string& rod, std::size_t end) {
  return rod + (end == 0 ? "_start" : "_end");
}

}  // namespace pliant
