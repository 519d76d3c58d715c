/// Displacements given as functions of place and time, by formulas of their components or as those of a rigid body, and
/// their rates.
#pragma once

#include "base/expression.hpp"
#include "base/vector3.hpp"
#include "time/rotation.hpp"

#include <array>
#include <optional>

namespace pliant {

/// Displacement, velocity and acceleration at a time.
struct Kinematics {
  double u = 0.0;  ///< [m]
  double v = 0.0;  ///< [m/s]
  double a = 0.0;  ///< [m/s^2]
};

/// Where a rigid body is: x = centre + translation + R (X - centre).
struct Placement {
  Vector3<double> translation{};  ///< of the centre [m]
  Quaternion rotation{1.0, 0.0, 0.0, 0.0};

  /// x - X of a point at `arm` = X - centre; small displacements keep their digits.
  Vector3<double> displacement(const Vector3<double>& arm) const;
};

/// The motion of a rigid body as formulas of t, as far as it is given.
struct RigidMotion {
  std::array<std::optional<Expression>, 3> translation;  ///< of the centre [m]; none: free
  Vector3<double> axis{};                                ///< of the rotation, of unit length
  Expression angle;                                      ///< [rad]
  Vector3<double> centre{};                              ///< a material point [m]

  /// At a time; free components of the translation as 0. `factor` multiplies translation and angle.
  Placement at(double time, double factor) const;
  bool depends_on_time() const;
};

struct GivenDisplacement {
  std::array<std::optional<Expression>, 3> components;  ///< [m]; none: free. Not used by a rigid body
  std::optional<RigidMotion> rigid = std::nullopt;

  bool gives(int component) const { return (rigid ? rigid->translation : components)[component].has_value(); }
  /// Of a component that is given; of a rigid body also of one that is free, relative to its centre. `factor`: the part
  /// of the motion that a load step has reached.
  double operator()(int component, const Vector3<double>& X, double time, double factor = 1.0) const;
};

/// A given displacement around one time, for many places and components: what does not depend on the place is found
/// once.
///
/// Velocities and accelerations are one-sided differences of sixth and fifth order over `time_scale`, before t (at
/// t = 0: after it; never before the start of the run), so that a formula with kinks at step boundaries is not
/// differentiated across one.
class GivenKinematics {
 public:
  /// `given` outlives the object.
  GivenKinematics(const GivenDisplacement& given, double time, double time_scale, double factor = 1.0);

  Kinematics operator()(int component, const Vector3<double>& X) const;

 private:
  static constexpr int num_times = 7;
  Kinematics of_formula(const Expression& formula, const Vector3<double>& X) const;

  const GivenDisplacement& given_;
  double factor_;
  std::array<double, num_times> times_{};  // t - k h
  double h_ = 0.0;
  std::array<Placement, num_times> placements_;        // of a rigid body
  std::array<std::optional<Kinematics>, 3> anywhere_;  // of components that do not depend on the place
};

}  // namespace pliant
