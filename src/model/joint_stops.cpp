#include "model/joint_stops.hpp"

#include "input/analysis.hpp"
#include "model/joint_turns.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <variant>

#include <fmt/format.h>

namespace pliant {
namespace {

/// The period of the bodies on a stop, in time steps: every method resolves it.
constexpr double steps_per_period = 10.0;
/// The effort of a stop begins smoothly over this part of the range, of 1 rad or of the size of the bodies.
constexpr double rounding_of_range = 1e-3;

/// The inertia of a body against a joint's coordinate: its mass [kg], or its moment about the axis [kg m^2].
class Inertia {
 public:
  Inertia(const Config& config, const NodeLayout& layout, const std::vector<int>& body_of_cell, const ModelJoint& joint)
      : config_(config), layout_(layout), body_of_cell_(body_of_cell), joint_(joint) {}

  double operator()(int body) const {
    const std::size_t first = config_.bodies.size() - config_.rigid_bodies.size();
    const auto b = static_cast<std::size_t>(body);
    return b < first ? of_mesh(body, config_.bodies[b].density.value_or(0.0))
                     : of_body(config_.rigid_bodies[b - first]);
  }

 private:
  bool turns() const { return joint_.type == JointType::hinge; }
  Vector3<double> arm(const Vector3<double>& x) const {
    const Vector3<double> d = x - joint_.point;
    return d - dot(d, joint_.axis) * joint_.axis;
  }
  double of_body(const RigidBodyConfig& body) const {
    if (!turns()) return body.mass;
    const auto& [xx, yy, zz, xy, yz, zx] = body.inertia.moments;
    const auto& [x, y, z] = joint_.axis;
    const Vector3<double> d = arm(body.center);
    return xx * x * x + yy * y * y + zz * z * z + 2.0 * (xy * x * y + yz * y * z + zx * z * x) + body.mass * dot(d, d);
  }
  /// A straight tetrahedron has int |d|^2 dV = V / 20 (sum |d_a|^2 + |sum d_a|^2).
  double of_mesh(int body, double density) const {
    double sum = 0.0;
    for (PetscInt c = 0; c < layout_.num_owned_cells; ++c) {
      if (body_of_cell_[static_cast<std::size_t>(c)] != body) continue;
      const auto nodes = layout_.nodes_of_cell(c);
      const Vector3<double> X = layout_.position(nodes[0]);
      const auto edge = [&](std::size_t a) { return Vector3<double>(layout_.position(nodes[a])) - X; };
      const double volume = dot(edge(1), cross(edge(2), edge(3))) / 6.0;
      double squares = 0.0;
      Vector3<double> total{};
      for (std::size_t a = 0; a < 4; ++a) {
        const Vector3<double> d = arm(layout_.position(nodes[a]));
        squares += dot(d, d);
        total = total + d;
      }
      sum += volume * (turns() ? (squares + dot(total, total)) / 20.0 : 1.0);
    }
    sum_in_place(layout_.comm, std::span(&sum, 1));
    return density * sum;
  }

  const Config& config_;
  const NodeLayout& layout_;
  const std::vector<int>& body_of_cell_;
  const ModelJoint& joint_;
};

}  // namespace

JointCoordinate coordinate_of_joint(const ModelJoint& joint) {
  if (joint.type == JointType::slider) return JointTravel{joint.point, joint.axis};
  const auto [e, f] = across(joint.axis);
  return JointAngle{e, f};
}

double beyond_stops(const JointStops& stops, const ModelJoint& joint, Vec q, Vec v) {
  const auto bodies = joint.mechanism->states(joint.bodies, q, v);
  const double coordinate = joint.angle != nullptr ? angle_of_joint(joint, bodies)
                                                   : coordinate_of(JointTravel{joint.point, joint.axis},
                                                                   bodies[0].motion(), bodies[1].motion());
  return std::max(stops.low - coordinate, coordinate - stops.high);
}

JointStops make_joint_stops(const Config& config, const NodeLayout& layout, const std::vector<int>& body_of_cell,
                            const JointConfig& given, const ModelJoint& joint, const std::array<int, 2>& bodies) {
  const auto& [low, high] = *given.limits;
  // One of two stops may be far away, where it never acts.
  const double wide = joint.angle != nullptr ? 1.0 : joint.mechanism->size();
  JointStops stops{low, high, 0.0, rounding_of_range * std::min(high - low, wide)};
  if (given.limit_stiffness) {
    stops.stiffness = *given.limit_stiffness;
    return stops;
  }
  // Two bodies swing against each other as one of I_1 I_2 / (I_1 + I_2).
  double per_inertia = 0.0;
  for (const int body : bodies) {
    if (body == JointEquation::ground) continue;
    const double inertia = Inertia(config, layout, body_of_cell, joint)(body);
    per_inertia += inertia > 0.0 ? 1.0 / inertia : std::numeric_limits<double>::infinity();
  }
  if (analysis_of(config) == Analysis::dynamic) {
    const double omega = 2.0 * std::numbers::pi / (steps_per_period * config.time.step);
    stops.stiffness = omega * omega / per_inertia;
  }
  if (stops.stiffness > 0.0) return stops;
  throw InputError(given.where,
                   fmt::format("joint '{}' has limits, and no masses and time steps from which the stiffness of its "
                               "stops would follow: give 'limit_stiffness'",
                               given.name));
}

}  // namespace pliant
