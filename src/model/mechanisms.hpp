/// The joints of the input between rigid parts of a mesh.
#pragma once

#include "energy/constraint/mechanism.hpp"
#include "model/constraint_ties.hpp"
#include "model/selections.hpp"

#include <memory>
#include <string>
#include <vector>

namespace pliant {

/// Two unit vectors across an axis of unit length, a right-handed frame with it: the second is the axis times the
/// first.
std::array<Vector3<double>, 2> across(const Vector3<double>& axis);

/// A joint and the two bodies that it connects.
struct ModelJoint {
  std::string name;
  JointType type = JointType::fixed;
  Vector3<double> point{};             ///< at the start [m]
  Vector3<double> second_point{};      ///< on the second body at the start; that of `point` unless it is a distance
  Vector3<double> axis{};              ///< at the start, of unit length; zero if it has none
  std::array<std::size_t, 2> parts{};  ///< constraints; `ground` for the ground
  Mechanism* mechanism = nullptr;      ///< of which it is a part
  std::array<int, 2> bodies{};         ///< of the mechanism
  std::size_t number = 0;              ///< among the joints of the mechanism
  std::shared_ptr<double> angle;       ///< of the last accepted state, with whole turns [rad]; none if it has no angle
  static constexpr auto ground = static_cast<std::size_t>(-1);
};

/// Rigid parts that turn freely, those that joints connect as mechanisms.
struct RigidSystem {
  std::vector<std::unique_ptr<DependentNodes>> dependents;
  std::vector<ModelJoint> joints;  ///< in the order of the input
};

/// Reports joints whose bodies are not there or not free, that have no axis, or that repeat or contradict others.
/// Collective.
RigidSystem make_rigid_system(const ConstraintsOnMesh& constraints, Selections& selections);

}  // namespace pliant
