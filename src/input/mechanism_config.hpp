/// Rigid bodies and joints of the input as typed values in SI units.
#pragma once

#include "base/error.hpp"
#include "base/expression.hpp"
#include "input/body_point.hpp"
#include "input/located.hpp"

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace pliant {

/// A rigid body without a mesh.
struct RigidBodyConfig {
  struct Inertia {
    std::array<double, 6> moments{};  ///< xx, yy, zz, xy, yz, zx, about the centre [kg m^2]
    Location where;
  };
  std::string name;
  double mass = 0.0;  ///< [kg]; 0 only where something is attached or coupled
  Inertia inertia;
  std::array<double, 3> center{};                 ///< of mass [m]
  std::optional<std::array<double, 3>> velocity;  ///< [m/s]; default: that of `initial`
  std::array<double, 3> angular_velocity{};       ///< [rad/s]
  /// The body's shape, for contact and pictures.
  struct Surface {
    Located<std::string> file;  ///< resolved against the input file's directory
    double scale = 1.0;
    std::optional<double> size;  ///< of the tetrahedra inside [m]
  };
  std::optional<Surface> surface;
  std::vector<Located<std::string>> attached;  ///< names of surfaces of other bodies that move with it
  std::vector<Located<std::string>> coupled;   ///< names of surfaces of other bodies whose mean motion it follows
  std::optional<double> coupling_stiffness;    ///< of these [N/m]; none: from the material and the area
  Location where;
};

enum class JointType { fixed, ball, hinge, slider, cylindrical, universal, planar, distance };
/// Their names in the input, in the order of the types.
inline constexpr std::array<std::pair<const char*, JointType>, 8> joint_types{{{"fixed", JointType::fixed},
                                                                               {"ball", JointType::ball},
                                                                               {"hinge", JointType::hinge},
                                                                               {"slider", JointType::slider},
                                                                               {"cylindrical", JointType::cylindrical},
                                                                               {"universal", JointType::universal},
                                                                               {"planar", JointType::planar},
                                                                               {"distance", JointType::distance}}};
inline const char* name_of(JointType type) {
  return joint_types[static_cast<std::size_t>(type)].first;
}

/// A joint between two rigid bodies or rigid parts, or one and the ground.
struct JointConfig {
  /// Efforts are torques [N m] about an axis or forces [N] along it.
  struct Motor {
    Expression target;            ///< angle [rad] or travel [m]; a function of t
    double stiffness = 0.0;       ///< [N m/rad] or [N/m]
    double damping = 0.0;         ///< [N m s/rad] or [N s/m]
    std::optional<double> limit;  ///< of the effort
    Expression effort;            ///< a function of t
  };
  struct Spring {
    double stiffness = 0.0;  ///< [N m/rad] or [N/m]
    double rest = 0.0;       ///< [rad] or [m]
  };
  /// Dry friction from the load that the joint carries.
  struct Bearing {
    double friction = 0.0;         ///< coefficient
    std::optional<double> radius;  ///< at which it slides [m]; a hinge has one
    std::optional<double> length;  ///< between the places that carry the load, along the axis [m]
  };
  std::string name;
  JointType type = JointType::fixed;
  std::array<std::string, 2> between;
  std::array<double, 3> point{};                      ///< [m]
  std::optional<std::array<double, 3>> axis;          ///< of any length
  std::optional<std::array<double, 3>> second_axis;   ///< of any length (universal)
  std::optional<std::array<double, 3>> second_point;  ///< [m] (distance)
  std::optional<Expression> motion;                   ///< angle [rad], travel [m] or change of a distance [m]
  std::optional<Motor> motor;                         ///< of a hinge or a slider, as what follows
  std::optional<Spring> spring;
  std::optional<double> damping;                ///< [N m s/rad] or [N s/m]
  std::optional<std::array<double, 2>> limits;  ///< of the angle [rad] or travel [m]
  std::optional<double> limit_stiffness;        ///< of the stops there [N m/rad] or [N/m]; none: from masses and steps
  std::optional<double> friction;               ///< [N m] or [N]
  std::optional<Bearing> bearing;
  double stick_rate = 0.0;  ///< [rad/s] or [m/s]
  Location where;
};

/// A string that is pulled at the first of its points, and anchored at the last.
struct TendonConfig {
  std::string name;
  std::vector<BodyPoint> points;                   ///< in their order along it; empty: those of `curve`
  std::string curve;                               ///< physical group; empty: none
  std::optional<std::array<double, 3>> pulled_at;  ///< near the end of the curve that is the first point [m]
  std::optional<Expression> tension;               ///< [N]; a function of t
  std::optional<Expression> pull;                  ///< [m]; a function of t, instead of `tension`
  std::optional<double> stiffness;                 ///< between what pulls and the string [N/m] (pull)
  double friction = 0.0;                           ///< coefficient, along the bodies
  double stick_velocity = 0.0;                     ///< [m/s]
  Location where;
};

/// A section of a rod.
struct Rectangle {
  double width = 0.0;             ///< across `up` [m]
  double height = 0.0;            ///< along `up` [m]
  std::array<double, 3> up{};     ///< of any length
  std::optional<double> torsion;  ///< constant J [m^4]; none: that of the rectangle
};

/// A slender elastic rod.
struct RodConfig {
  std::string name;
  std::vector<std::array<double, 3>> points;  ///< along it [m]; empty: the nodes of `curve`
  std::string curve;                          ///< physical group; empty: none
  std::optional<int> segments;                ///< between two neighbouring points
  std::optional<double> size;                 ///< greatest length of segments instead [m]
  std::optional<double> radius;               ///< of a round section [m]
  std::optional<Rectangle> section;           ///< none: round
  double density = 0.0;                       ///< [kg/m^3]
  double youngs_modulus = 0.0;                ///< [Pa]
  double poissons_ratio = 0.0;
  double damping = 0.0;             ///< viscous resistance per stiffness [s]
  std::optional<bool> bends;        ///< whether it resists bending and twist; none: unless that is negligible
  Located<std::string> start, end;  ///< what holds its first and last section: `ground`, a rigid body; empty: nothing
  Location where;

  const std::string& holder(std::size_t of_end) const { return of_end == 0 ? start.value : end.value; }
};

/// A spring, a damper or both, between two points.
struct SpringConfig {
  std::string name;
  std::array<BodyPoint, 2> points;
  double stiffness = 0.0;      ///< [N/m]
  std::optional<double> rest;  ///< length without force [m]; default: that at the start
  double damping = 0.0;        ///< [N s/m]
  bool is_tension_only = false;
  Location where;
};

}  // namespace pliant
