/// Rigid bodies and joints of the input as typed values in SI units.
#pragma once

#include "base/error.hpp"
#include "base/expression.hpp"

#include <array>
#include <optional>
#include <string>

namespace pliant {

/// A rigid body without a mesh.
struct RigidBodyConfig {
  struct Inertia {
    std::array<double, 6> moments{};  ///< xx, yy, zz, xy, yz, zx, about the centre [kg m^2]
    Location where;
  };
  std::string name;
  double mass = 0.0;  ///< [kg]
  Inertia inertia;
  std::array<double, 3> center{};            ///< of mass [m]
  std::array<double, 3> velocity{};          ///< [m/s]
  std::array<double, 3> angular_velocity{};  ///< [rad/s]
  Location where;
};

enum class JointType { fixed, ball, hinge, slider, cylindrical, universal, planar, distance };

/// A joint between two rigid bodies or rigid parts, or one and the ground.
struct JointConfig {
  std::string name;
  JointType type = JointType::fixed;
  std::array<std::string, 2> between;
  std::array<double, 3> point{};                      ///< [m]
  std::optional<std::array<double, 3>> axis;          ///< of any length
  std::optional<std::array<double, 3>> second_axis;   ///< of any length (universal)
  std::optional<std::array<double, 3>> second_point;  ///< [m] (distance)
  std::optional<Expression> motion;                   ///< angle [rad], travel [m] or change of a distance [m]
  Location where;
};

}  // namespace pliant
