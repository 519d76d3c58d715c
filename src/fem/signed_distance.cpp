#include "fem/signed_distance.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace pliant {
namespace {

constexpr int num_segments = 48;  // of a circle in pictures

/// A unit vector orthogonal to another one.
Vector3<double> orthogonal_to(const Vector3<double>& n) {
  Vector3<double> e{};
  e[std::ranges::min_element(n, {}, [](double x) { return std::abs(x); }) - n.begin()] = 1.0;
  return unit(cross(n, e));
}

/// A vector split into its part along a direction and its part across, the latter as length times direction.
struct Split {
  Split(const Vector3<double>& r, const Vector3<double>& axis) : along(dot(r, axis)) {
    const Vector3<double> rest = r - along * axis;
    across = norm(rest);
    direction = across > 0.0 ? (1.0 / across) * rest : orthogonal_to(axis);
  }
  double along;
  double across;
  Vector3<double> direction;
};

/// For points at unit distance from an axis: the rotating part, (I - e e - a a) / radius.
Tensor3<double> round_curvature(const Vector3<double>& direction, const Vector3<double>& axis, double radius) {
  return (1.0 / radius) * (add_to_diagonal(-1.0 * outer(direction, direction), 1.0) - outer(axis, axis));
}

/// Distance to a point minus the radius.
DistanceAt from_point(const Vector3<double>& r, double radius) {
  const double length = norm(r);
  if (length == 0.0) return {-radius, {0.0, 0.0, 1.0}, {}};
  const Vector3<double> n = (1.0 / length) * r;
  return {length - radius, n, (1.0 / length) * add_to_diagonal(-1.0 * outer(n, n), 1.0)};
}

/// The surface of revolution of a curve (height along the axis, radius), from end to end.
std::vector<TrianglePatch> revolved(const Vector3<double>& center, const Vector3<double>& axis,
                                    const std::vector<std::array<double, 2>>& curve) {
  const Vector3<double> e = orthogonal_to(axis), f = cross(axis, e);
  const auto at = [&](std::size_t k, int s) {
    const double angle = 2.0 * std::numbers::pi * s / num_segments;
    const auto [height, radius] = curve[k];
    return center + height * axis + radius * (std::cos(angle) * e + std::sin(angle) * f);
  };
  std::vector<TrianglePatch> result;
  for (std::size_t k = 0; k + 1 < curve.size(); ++k) {
    for (int s = 0; s < num_segments; ++s) {
      result.push_back({at(k, s), at(k, s + 1), at(k + 1, s + 1)});
      result.push_back({at(k, s), at(k + 1, s + 1), at(k + 1, s)});
    }
  }
  return result;
}

/// Points of a half circle around the axis.
void add_arc(std::vector<std::array<double, 2>>& curve, double middle, double radius, double from, double to) {
  constexpr int in_quarter = num_segments / 4;
  for (int s = 0; s <= in_quarter; ++s) {
    const double angle = from + (to - from) * s / in_quarter;
    curve.push_back({middle + radius * std::sin(angle), radius * std::cos(angle)});
  }
}

class PlaneDistance final : public SignedDistance {
 public:
  explicit PlaneDistance(const PlaneShape& shape) : shape_(shape) {}
  DistanceAt at(const Vector3<double>& x) const override { return {distance(x), shape_.normal, {}}; }
  double distance(const Vector3<double>& x) const override { return dot(shape_.normal, x - shape_.point); }
  std::vector<TrianglePatch> drawing(const Vector3<double>& middle, double extent) const override {
    const Vector3<double> foot = middle - distance(middle) * shape_.normal;
    const Vector3<double> e = extent * orthogonal_to(shape_.normal), f = cross(shape_.normal, e);
    const Vector3<double> a = foot - e - f, b = foot + e - f, c = foot + e + f, d = foot - e + f;
    return {{a, b, c}, {a, c, d}};
  }

 private:
  PlaneShape shape_;
};

class SphereDistance final : public SignedDistance {
 public:
  explicit SphereDistance(const SphereShape& shape) : shape_(shape) {}
  DistanceAt at(const Vector3<double>& x) const override { return from_point(x - shape_.center, shape_.radius); }
  double distance(const Vector3<double>& x) const override { return norm(x - shape_.center) - shape_.radius; }
  std::vector<TrianglePatch> drawing(const Vector3<double>& /*middle*/, double /*extent*/) const override {
    std::vector<std::array<double, 2>> curve;
    add_arc(curve, 0.0, shape_.radius, -0.5 * std::numbers::pi, 0.0);
    add_arc(curve, 0.0, shape_.radius, 0.0, 0.5 * std::numbers::pi);
    return revolved(shape_.center, {0.0, 0.0, 1.0}, curve);
  }

 private:
  SphereShape shape_;
};

/// With u the distance to the round side and w that to the flat ends: sqrt(u^2 + w^2) if both are positive, else the
/// larger one.
class CylinderDistance final : public SignedDistance {
 public:
  explicit CylinderDistance(const CylinderShape& shape) : shape_(shape) {}

  DistanceAt at(const Vector3<double>& x) const override {
    const Split r(x - shape_.center, shape_.axis);
    const double u = r.across - shape_.radius, w = std::abs(r.along) - 0.5 * shape_.length;
    const Vector3<double> end = std::copysign(1.0, r.along) * shape_.axis;
    if (std::min(u, w) <= 0.0) {
      if (w > u) return {w, end, {}};
      const bool on_axis = r.across == 0.0;
      return {u, r.direction, on_axis ? Tensor3<double>{} : round_curvature(r.direction, shape_.axis, r.across)};
    }
    const double d = std::hypot(u, w);
    const Vector3<double> n = (1.0 / d) * (u * r.direction + w * end);
    return {d, n,
            (1.0 / d) * (outer(r.direction, r.direction) + outer(shape_.axis, shape_.axis) - outer(n, n)) +
                (u / d) * round_curvature(r.direction, shape_.axis, r.across)};
  }

  double distance(const Vector3<double>& x) const override {
    const Split r(x - shape_.center, shape_.axis);
    const double u = r.across - shape_.radius, w = std::abs(r.along) - 0.5 * shape_.length;
    return std::min(u, w) > 0.0 ? std::hypot(u, w) : std::max(u, w);
  }

  std::vector<TrianglePatch> drawing(const Vector3<double>& middle, double extent) const override {
    const double half = 0.5 * shape_.length, R = shape_.radius;
    if (std::isinf(half)) {
      const double at = dot(middle - shape_.center, shape_.axis);
      return revolved(shape_.center, shape_.axis, {{at - extent, R}, {at + extent, R}});
    }
    return revolved(shape_.center, shape_.axis, {{-half, 0.0}, {-half, R}, {half, R}, {half, 0.0}});
  }

 private:
  CylinderShape shape_;
};

class CapsuleDistance final : public SignedDistance {
 public:
  explicit CapsuleDistance(const CapsuleShape& shape) : shape_(shape) {}

  DistanceAt at(const Vector3<double>& x) const override {
    const Split r(x - shape_.center, shape_.axis);
    if (std::abs(r.along) >= 0.5 * shape_.length) return from_point(x - nearest(r.along), shape_.radius);
    const bool on_axis = r.across == 0.0;
    return {r.across - shape_.radius, r.direction,
            on_axis ? Tensor3<double>{} : round_curvature(r.direction, shape_.axis, r.across)};
  }

  double distance(const Vector3<double>& x) const override {
    return norm(x - nearest(dot(x - shape_.center, shape_.axis))) - shape_.radius;
  }

  std::vector<TrianglePatch> drawing(const Vector3<double>& /*middle*/, double /*extent*/) const override {
    std::vector<std::array<double, 2>> curve;
    const double half = 0.5 * shape_.length;
    add_arc(curve, -half, shape_.radius, -0.5 * std::numbers::pi, 0.0);
    add_arc(curve, half, shape_.radius, 0.0, 0.5 * std::numbers::pi);
    return revolved(shape_.center, shape_.axis, curve);
  }

 private:
  /// Point of the axis' piece.
  Vector3<double> nearest(double along) const {
    const double half = 0.5 * shape_.length;
    return shape_.center + std::clamp(along, -half, half) * shape_.axis;
  }

  CapsuleShape shape_;
};

/// With q the distances to the three pairs of faces: the length of the positive ones, or if there are none the largest.
class BoxDistance final : public SignedDistance {
 public:
  explicit BoxDistance(const BoxShape& shape) : shape_(shape) {}

  DistanceAt at(const Vector3<double>& x) const override {
    const Vector3<double> r = x - shape_.center;
    Vector3<double> out{};
    std::size_t largest = 0;
    double most = -std::numeric_limits<double>::infinity(), square_length = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double q = std::abs(r[i]) - 0.5 * shape_.size[i];
      if (q > most) std::tie(most, largest) = std::pair(q, i);
      out[i] = std::max(q, 0.0);
      square_length += out[i] * out[i];
    }
    DistanceAt result;
    if (most <= 0.0) {
      result.d = most;
      result.n[largest] = std::copysign(1.0, r[largest]);
      return result;
    }
    result.d = std::sqrt(square_length);
    for (std::size_t i = 0; i < 3; ++i) result.n[i] = std::copysign(out[i] / result.d, r[i]);
    result.curvature = (-1.0 / result.d) * outer(result.n, result.n);
    for (int i = 0; i < 3; ++i) {
      if (out[i] > 0.0) result.curvature(i, i) += 1.0 / result.d;
    }
    return result;
  }

  std::vector<TrianglePatch> drawing(const Vector3<double>& /*middle*/, double /*extent*/) const override {
    const auto corner = [&](int bits) {
      Vector3<double> x = shape_.center;
      for (int i = 0; i < 3; ++i) x[i] += ((bits >> i & 1) != 0 ? 0.5 : -0.5) * shape_.size[i];
      return x;
    };
    constexpr std::array<std::array<int, 4>, 6> faces{
        {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
    std::vector<TrianglePatch> result;
    for (const auto& [a, b, c, d] : faces) {
      result.push_back({corner(a), corner(b), corner(c)});
      result.push_back({corner(a), corner(c), corner(d)});
    }
    return result;
  }

 private:
  BoxShape shape_;
};

class Hollow final : public SignedDistance {
 public:
  explicit Hollow(std::unique_ptr<SignedDistance> solid) : solid_(std::move(solid)) {}
  DistanceAt at(const Vector3<double>& x) const override {
    const DistanceAt s = solid_->at(x);
    return {-s.d, -1.0 * s.n, -1.0 * s.curvature};
  }
  double distance(const Vector3<double>& x) const override { return -solid_->distance(x); }
  std::vector<TrianglePatch> drawing(const Vector3<double>& middle, double extent) const override {
    auto result = solid_->drawing(middle, extent);
    for (TrianglePatch& triangle : result) std::swap(triangle[1], triangle[2]);
    return result;
  }

 private:
  std::unique_ptr<SignedDistance> solid_;
};

}  // namespace

std::unique_ptr<SignedDistance> make_distance(const PlaneShape& shape) {
  return std::make_unique<PlaneDistance>(shape);
}
std::unique_ptr<SignedDistance> make_distance(const SphereShape& shape) {
  return std::make_unique<SphereDistance>(shape);
}
std::unique_ptr<SignedDistance> make_distance(const CylinderShape& shape) {
  return std::make_unique<CylinderDistance>(shape);
}
std::unique_ptr<SignedDistance> make_distance(const CapsuleShape& shape) {
  return std::make_unique<CapsuleDistance>(shape);
}
std::unique_ptr<SignedDistance> make_distance(const BoxShape& shape) {
  return std::make_unique<BoxDistance>(shape);
}
std::unique_ptr<SignedDistance> hollow(std::unique_ptr<SignedDistance> solid) {
  return std::make_unique<Hollow>(std::move(solid));
}

}  // namespace pliant
