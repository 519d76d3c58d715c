/// Dry friction of hinges and sliders that follows the load in their bearings.
#pragma once

#include "energy/rigid/joint_coordinate.hpp"
#include "energy/rigid/joint_system.hpp"

#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace pliant {

/// The bearing of a hinge or the guide of a slider. It carries the force F and the torque T of the joint at two places
/// that are `length` apart along the axis n, with the joint's point on the second body in their middle. With F_n =
/// F . n, T_n = T . n and F_t = F - F_n n, the loads there are
///
///   N = |F_t / 2 + n x T / length| + |F_t / 2 - n x T / length|      (|F_t| without a length)
///
/// and dry friction exerts at most mu radius (N + |F_n|) [N m] in a hinge, whose collar carries F_n at the radius of
/// its pin, and mu (N + |T_n| / radius) [N] in a slider (without the second part if it has no radius).
struct JointBearing {
  JointCoordinate coordinate;    ///< its rate is that of sliding
  double friction = 0.0;         ///< mu [1]
  std::optional<double> radius;  ///< [m]; a hinge has one
  std::optional<double> length;  ///< [m]
  Vector3<double> axis{};        ///< n at the start, of unit length
  Vector3<double> point{};       ///< at the start [m]
  std::array<int, 2> bodies{};   ///< as in JointEquation
  std::size_t joint = 0;         ///< JointEquation::joint
};

/// The largest effort of friction in a bearing that carries the reaction [N m] or [N]; n: its axis at present.
double largest_friction(const JointBearing& bearing, const JointReaction& reaction, const Vector3<double>& n);

/// The bearings of a mechanism, and the largest efforts of friction in them.
class JointBearings {
 public:
  bool empty() const { return bearings_.empty(); }
  /// Adds one; returns its largest effort, which `measure` sets.
  std::shared_ptr<const double> add(const JointBearing& bearing);
  /// Sets all of them to zero.
  void release();
  /// Sets them to what follows from the forces phi on the unknowns of the parts, in equilibrium but for any friction of
  /// the bearings themselves: the forces lambda of the joints' equations with the derivatives G by virtual
  /// displacements, G^T lambda = phi, are taken where that friction does no work.
  void measure(std::span<const PartMotion> parts, const JointSystem& joints, const JointSystem::Given& given,
               const JointSystem::Vector& phi);

 private:
  /// The derivatives of the coordinates by the parts' virtual displacements, a row for each bearing; `first`:
  /// the first unknown of each part.
  JointSystem::Matrix slopes(std::span<const PartMotion> parts, std::span<const std::size_t> first) const;

  std::vector<JointBearing> bearings_;
  std::vector<std::shared_ptr<double>> largest_;
};

}  // namespace pliant
