#include "model/joint_efforts.hpp"

#include "input/analysis.hpp"
#include "model/joint_stops.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

namespace pliant {
namespace {

JointMotor motor_of(const JointConfig::Motor& motor, bool is_static) {
  return {motor.target, motor.stiffness, is_static ? 0.0 : motor.damping, motor.limit, motor.effort};
}

/// The laws of a joint that follow from its coordinate and rate alone. A static equilibrium has no rates.
std::vector<JointLaw> laws_of(const JointConfig& joint, bool is_static) {
  std::vector<JointLaw> laws;
  if (joint.spring) laws.emplace_back(JointSpring{joint.spring->stiffness, joint.spring->rest});
  if (joint.damping.value_or(0.0) > 0.0 && !is_static) laws.emplace_back(JointDamper{*joint.damping});
  if (joint.friction.value_or(0.0) > 0.0 && !is_static) {
    laws.emplace_back(JointFriction{*joint.friction, joint.stick_rate});
  }
  if (joint.motor) laws.emplace_back(motor_of(*joint.motor, is_static));
  return laws;
}

/// Friction in the bearing of a joint; nothing without a coefficient, and in a static equilibrium.
std::optional<BearingFriction> bearing_of(const JointConfig& joint, const ModelJoint& model, bool is_static) {
  if (!joint.bearing || !(joint.bearing->friction > 0.0) || is_static) return std::nullopt;
  const auto& [friction, radius, length] = *joint.bearing;
  return BearingFriction{model.mechanism->follow({coordinate_of_joint(model), friction, radius, length, model.axis,
                                                  model.second_point, model.bodies, model.number}),
                         joint.stick_rate};
}

/// The number of the rigid body that a constraint makes rigid.
std::optional<int> rigid_body_of(const Config& config, const ConstraintConfig& constraint) {
  for (std::size_t b = 0; b < config.bodies.size(); ++b) {
    const BodyConfig& body = config.bodies[b];
    if (body.is_rigid && body.part.kind == constraint.part.kind && body.part.name == constraint.part.name) {
      return static_cast<int>(b);
    }
  }
  return std::nullopt;
}

}  // namespace

JointEfforts make_joint_efforts(const Config& config, const NodeLayout& layout, const std::vector<int>& body_of_cell,
                                std::span<const ModelJoint> joints) {
  JointEfforts efforts;
  const bool is_static = analysis_of(config) == Analysis::static_equilibrium;
  std::vector<JointBody> bodies;
  std::array<std::vector<JointEffort::Joint>, std::variant_size_v<JointLaw>> of_kinds;
  efforts.laws.resize(joints.size());
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const JointConfig& given = config.joints[j];
    std::vector<JointLaw>& laws = efforts.laws[j];
    laws = laws_of(given, is_static);
    if (const auto bearing = bearing_of(given, joints[j], is_static)) laws.emplace_back(*bearing);
    if (laws.empty() && !given.limits) continue;
    JointEffort::Joint joint{{-1, -1}, coordinate_of_joint(joints[j]), {}, joints[j].angle};
    for (std::size_t side = 0; side < 2; ++side) {
      if (joints[j].parts[side] == ModelJoint::ground) continue;
      const auto body = rigid_body_of(config, config.constraints[joints[j].parts[side]]);
      if (!body) {
        throw InputError(given.where,
                         fmt::format("joint '{}' has a spring, a motor, limits, damping or friction, and '{}' is a "
                                     "part of a soft body: these act between rigid bodies and the ground; make it a "
                                     "rigid body, a volume by 'rigid: true', a surface by 'attached' of one of "
                                     "'rigid_bodies', and join that",
                                     given.name, given.between[side]));
      }
      joint.bodies[side] = *body;
      if (std::ranges::find(bodies, *body, &JointBody::key) == bodies.end()) {
        bodies.push_back(joint_body(layout, body_of_cell, *body));
      }
    }
    if (given.limits) laws.emplace_back(make_joint_stops(config, layout, body_of_cell, given, joints[j], joint.bodies));
    for (const JointLaw& law : laws) {
      joint.law = law;
      of_kinds[law.index()].push_back(joint);
    }
  }
  std::ranges::sort(bodies, {}, &JointBody::key);
  // Without inertia stages are steps of backward Euler, and dry friction is followed by minima of a potential.
  const auto rates = analysis_of(config) == Analysis::dynamic ? JointRates::derivatives : JointRates::differences;
  for (auto& of_kind : of_kinds) {
    if (!of_kind.empty()) efforts.terms.push_back(std::make_unique<JointEffort>(bodies, std::move(of_kind), rates));
  }
  return efforts;
}

std::string_view ending_of(const JointLaw& law) {
  struct Ending {
    std::string_view operator()(const JointSpring&) const { return "_spring"; }
    std::string_view operator()(const JointDamper&) const { return "_damping"; }
    std::string_view operator()(const JointMotor&) const { return "_effort"; }
    std::string_view operator()(const JointStops&) const { return "_stops"; }
    std::string_view operator()(const JointFriction&) const { return "_friction"; }
    std::string_view operator()(const BearingFriction&) const { return "_bearing"; }
  };
  return std::visit(Ending{}, law);
}

void require_finite_formulas(const Config& config, double time) {
  const auto require = [&](const Expression& formula, const Location& where, const std::string& what) {
    if (std::isfinite(formula(0.0, 0.0, 0.0, time))) return;
    throw InputError(where, fmt::format("{} is not finite at t = {:g}", what, time));
  };
  for (const JointConfig& joint : config.joints) {
    if (joint.motion) require(*joint.motion, joint.where, "the motion of joint '" + joint.name + "'");
    if (!joint.motor) continue;
    require(joint.motor->target, joint.where, "the target of the motor of joint '" + joint.name + "'");
    require(joint.motor->effort, joint.where, "the effort of the motor of joint '" + joint.name + "'");
  }
  for (const TendonConfig& tendon : config.tendons) {
    if (tendon.tension) require(*tendon.tension, tendon.where, "the tension of tendon '" + tendon.name + "'");
    if (tendon.pull) require(*tendon.pull, tendon.where, "the pull of tendon '" + tendon.name + "'");
  }
}

}  // namespace pliant
