/// Solids given by their signed distance: the shapes of obstacles.
#pragma once

#include "base/vector3.hpp"

#include <array>
#include <limits>
#include <memory>
#include <vector>

namespace pliant {

/// The distance of a point to a surface and its derivatives in space.
struct DistanceAt {
  double d = 0.0;               ///< negative inside the solid [m]
  Vector3<double> n{};          ///< grad d, of unit length, away from the solid
  Tensor3<double> curvature{};  ///< grad n [1/m]; n is in its kernel, and it is semidefinite: >= 0 of convex solids, <=
                                ///< 0 of hollows in them
};

/// A triangle as three corners [m], anticlockwise seen from outside.
using TrianglePatch = std::array<Vector3<double>, 3>;

/// A solid at rest. Its distance is 1-Lipschitz: |d(x) - d(y)| <= |x - y|.
class SignedDistance {
 public:
  virtual ~SignedDistance() = default;
  virtual DistanceAt at(const Vector3<double>& x) const = 0;
  /// `at(x).d`, without the derivatives.
  virtual double distance(const Vector3<double>& x) const { return at(x).d; }
  /// A triangulation for pictures; of an unbounded surface, the part around `middle` up to `extent` [m] from there. Two
  /// triangles are the sheet of a plane; closed surfaces have more.
  virtual std::vector<TrianglePatch> drawing(const Vector3<double>& middle, double extent) const = 0;
};

/// A half-space.
struct PlaneShape {
  Vector3<double> point{};
  Vector3<double> normal{};  ///< of unit length, out of the solid
};

struct SphereShape {
  Vector3<double> center{};
  double radius = 0.0;  ///< [m]
};

/// Points within `radius` of an axis, between flat ends.
struct CylinderShape {
  Vector3<double> center{};
  Vector3<double> axis{};  ///< of unit length
  double radius = 0.0;     ///< [m]
  double length = std::numeric_limits<double>::infinity();
};

/// Points within `radius` of a piece of length `length` of an axis.
struct CapsuleShape {
  Vector3<double> center{};
  Vector3<double> axis{};  ///< of unit length
  double radius = 0.0;     ///< [m]
  double length = 0.0;     ///< between the centres of the round ends [m]
};

/// With edges along x, y and z.
struct BoxShape {
  Vector3<double> center{};
  Vector3<double> size{};  ///< [m]
};

std::unique_ptr<SignedDistance> make_distance(const PlaneShape& shape);
std::unique_ptr<SignedDistance> make_distance(const SphereShape& shape);
std::unique_ptr<SignedDistance> make_distance(const CylinderShape& shape);
std::unique_ptr<SignedDistance> make_distance(const CapsuleShape& shape);
std::unique_ptr<SignedDistance> make_distance(const BoxShape& shape);

/// The space around: a body is kept within the solid instead of out of it.
std::unique_ptr<SignedDistance> hollow(std::unique_ptr<SignedDistance> solid);

}  // namespace pliant
