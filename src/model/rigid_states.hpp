/// How rigid bodies and joints move: the numbers that history.csv has of them.
#pragma once

#include "model/model.hpp"

#include <string>
#include <vector>

namespace pliant {

/// Observes the rigid bodies of a model, with a mesh and without, and its joints. Columns and values are in the same
/// order: for each body `<name>_x, _y, _z` (centre of mass [m]), `_vx, _vy, _vz` [m/s], `_qw, _qx, _qy, _qz` (rotation
/// since the start, a unit quaternion with qw >= 0), `_wx, _wy, _wz` (angular velocity in space [rad/s]); for each
/// joint `<name>_angle` with whole turns [rad] or `<name>_travel` [m], `<name>_rate`, what its laws exert (ending_of),
/// `<name>_fx, _fy, _fz` [N], `_tx, _ty, _tz` (force and torque on the second body, at the joint [N m]).
class RigidStates {
 public:
  /// Collective.
  RigidStates(const Config& config, const Model& model);

  std::vector<std::string> columns() const;
  /// At q and v; `reactions`: of the joints. Collective.
  std::vector<double> values(const Instant& at, Vec q, Vec v, const std::vector<JointReaction>& reactions) const;

 private:
  struct Body {
    std::string name;
    std::vector<PetscInt> nodes;  // owned
    Vector3<double> centre{};     // of mass, in the reference configuration
  };
  const Model& model_;
  std::vector<Body> bodies_;
};

}  // namespace pliant
