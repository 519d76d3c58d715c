/// Tendons, springs and joints as results show them: as lines, and where these are.
#pragma once

#include "io/mechanism_writer.hpp"
#include "model/model.hpp"

#include <array>
#include <vector>

namespace pliant {

/// A joint is drawn at its place on the second body, with its axis, which moves with the first one, as a line about a
/// sixth as long as the model: of a slider longer and with bars at its ends, as of a cylindrical joint. A universal
/// joint has both its axes, a planar one the normal and a square, a ball and what is fixed a small cross; a distance is
/// the line between its points.
class MechanismDrawing {
 public:
  /// `model` outlives the object. Collective.
  MechanismDrawing(const Config& config, const Model& model);

  /// In the reference configuration; without names if the model has no tendon, spring or joint.
  const OutputMechanisms& parts() const { return parts_; }
  /// At q and v. Collective.
  MechanismState state(const Instant& at, Vec q, Vec v) const;

 private:
  /// A point that moves with one of a joint's two bodies.
  struct JointPoint {
    std::size_t body;   // 0 or 1
    Vector3<double> X;  // in the reference configuration [m]
  };
  std::size_t add_part(const std::string& name, const std::string& kind);
  std::int64_t add_point(const Vector3<double>& X);
  void add_segment(std::int64_t from, std::int64_t to);
  void add_line(const std::vector<Vector3<double>>& places);
  void add_line(std::size_t joint, const JointPoint& from, const JointPoint& to);
  void add_joint(std::size_t joint, const JointConfig& config, double size);
  /// Adds the points and the tensions of tendons and springs. Collective.
  void move_lines(const Instant& at, Vec q, Vec v, MechanismState& state) const;

  const Model& model_;
  OutputMechanisms parts_;
  std::vector<std::vector<JointPoint>> joint_points_;  // of each joint, the last points
};

}  // namespace pliant
