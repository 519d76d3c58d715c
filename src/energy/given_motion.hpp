/// Prescribed displacements as functions of place and time, by formulas of their components or as rigid motions, and
/// their rates.
#pragma once

#include "base/expression.hpp"
#include "base/formula_tree.hpp"
#include "base/vector3.hpp"
#include "time/rotation.hpp"

#include <array>
#include <optional>

namespace pliant {

/// The side of a time from which rates are taken.
enum class Side { before, after };

/// Displacement, velocity and acceleration at a time.
struct Kinematics {
  double u = 0.0;  ///< [m]
  double v = 0.0;  ///< [m/s]
  double a = 0.0;  ///< [m/s^2]
};

/// The placement of a rigid body: x = centre + translation + R (X - centre).
struct Placement {
  Vector3<double> translation{};  ///< of the centre [m]
  Quaternion rotation{1.0, 0.0, 0.0, 0.0};

  /// x - X of a point at `arm` = X - centre; keeps the digits of small displacements.
  Vector3<double> displacement(const Vector3<double>& arm) const;
};

/// The prescribed motion of a rigid body, as formulas of t.
struct RigidMotion {
  std::array<std::optional<Expression>, 3> translation;  ///< of the centre [m]; empty: free
  Vector3<double> axis{};                                ///< of the rotation, of unit length
  Expression angle;                                      ///< [rad]
  Vector3<double> centre{};                              ///< a material point [m]

  /// At a time; free components of the translation are 0. `factor` multiplies translation and angle.
  Placement at(double time, double factor) const;
  bool depends_on_time() const;
};

struct GivenDisplacement {
  std::array<std::optional<Expression>, 3> components;  ///< [m]; empty: free. Not used by a rigid body
  std::optional<RigidMotion> rigid = std::nullopt;

  bool gives(int component) const { return (rigid ? rigid->translation : components)[component].has_value(); }
  /// The motion of a prescribed component; for a rigid body also of a free one, relative to its centre. `factor`: the
  /// part of the motion that a load step has reached.
  double operator()(int component, const Vector3<double>& X, double time, double factor = 1.0) const;
};

/// A prescribed displacement at one time, for many places and components: evaluates once what does not depend on the
/// place.
///
/// Velocities and accelerations are the exact derivatives of the formulas, one-sided before t or after it (after it at
/// t = 0, the start of the run), and where a formula jumps the value is that of the side: a step ends before the jump.
/// Where these are not finite, as those of sqrt(t) at 0, they are differences over `time_scale`.
class GivenKinematics {
 public:
  /// `given` must outlive the object. `time_scale`: the motion is smooth over this time on that side.
  GivenKinematics(const GivenDisplacement& given, double time, double time_scale, double factor = 1.0,
                  Side side = Side::before);

  Kinematics operator()(int component, const Vector3<double>& X) const;

 private:
  Kinematics of_formula(const Expression& formula, const Vector3<double>& X) const;
  Kinematics of_rigid_body(std::size_t component, const Vector3<double>& arm) const;

  const GivenDisplacement& given_;
  double time_, side_, end_;  // rates hold at `side_`, next to `time_`; the motion is smooth up to `end_`
  double factor_;
  Placement placement_;            // of a rigid body
  std::array<TimeJet, 3> centre_;  // ... the motion of its centre
  TimeJet angle_;
  std::array<std::optional<Kinematics>, 3> anywhere_;  // of components that do not depend on the place
};

}  // namespace pliant
