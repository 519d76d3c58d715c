#include "model/rigid_states.hpp"

#include "energy/rigid/rigid_fit.hpp"
#include "model/joint_efforts.hpp"
#include "model/joint_turns.hpp"
#include "model/rigid_bodies.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"

#include <algorithm>

namespace pliant {
namespace {

constexpr std::array axes{"x", "y", "z"};

bool has_travel(JointType type) {
  return type == JointType::slider || type == JointType::cylindrical || type == JointType::distance;
}

}  // namespace

RigidStates::RigidStates(const Config& config, const Model& model) : model_(model) {
  const NodeLayout& layout = model.layout();
  const Config completed = with_rigid_bodies(config);
  for (std::size_t b = 0; b < completed.bodies.size(); ++b) {
    if (!completed.bodies[b].is_rigid) continue;
    Body body{model.body_names()[b], {}, {}};
    std::vector<char> is_of_body(static_cast<std::size_t>(layout.num_local_nodes), 0);
    for (PetscInt c = 0; c < layout.num_local_cells; ++c) {
      if (model.body_of_cell()[static_cast<std::size_t>(c)] != static_cast<int>(b)) continue;
      const auto nodes = layout.nodes_of_cell(c);
      for (const PetscInt n : nodes) is_of_body[static_cast<std::size_t>(n)] = 1;
    }
    body.centre =
        mass_of_rigid_body(completed, layout, model.body_of_cell(), model.shells(), static_cast<int>(b)).center;
    for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) {
      if (is_of_body[static_cast<std::size_t>(n)] != 0) body.nodes.push_back(n);
    }
    bodies_.push_back(std::move(body));
  }
}

std::vector<std::string> RigidStates::columns() const {
  std::vector<std::string> names;
  const auto add = [&](const std::string& name, const std::string& what) {
    for (const char* axis : axes) names.push_back(name + what + axis);
  };
  for (const Body& body : bodies_) {
    add(body.name, "_");
    add(body.name, "_v");
    names.push_back(body.name + "_qw");
    add(body.name, "_q");
    add(body.name, "_w");
  }
  const auto& joints = model_.constraints().joints();
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const ModelJoint& joint = joints[j];
    if (joint.angle != nullptr) names.push_back(joint.name + "_angle");
    if (has_travel(joint.type)) names.push_back(joint.name + "_travel");
    if ((joint.angle != nullptr) != has_travel(joint.type)) names.push_back(joint.name + "_rate");
    for (const JointLaw& law : model_.laws_of_joint(j)) names.push_back(joint.name + std::string(ending_of(law)));
    add(joint.name, "_f");
    add(joint.name, "_t");
  }
  return names;
}

std::vector<double> RigidStates::values(const Instant& at, Vec q, Vec v,
                                        const std::vector<JointReaction>& reactions) const {
  std::vector<double> result;
  const auto add = [&](const auto& numbers) { result.insert(result.end(), numbers.begin(), numbers.end()); };
  for (const Body& body : bodies_) {
    const Placement place = nearest_placement(model_.layout(), body.nodes, body.centre, q);
    const auto [velocity, omega] = nearest_velocity(model_.layout(), body.nodes, body.centre, place, v);
    add(body.centre + place.translation);
    add(velocity);
    const double sign = place.rotation[0] < 0.0 ? -1.0 : 1.0;
    for (const double number : place.rotation) result.push_back(sign * number);
    add(omega);
  }
  const auto& joints = model_.constraints().joints();
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const ModelJoint& joint = joints[j];
    const auto bodies = joint.mechanism->states(joint.bodies, q, v);
    const auto& [a, b] = bodies;
    const Vector3<double> axis = joint.axis;
    const Vector3<double> n = a.motion().direction(axis);
    const Vector3<double> n_rate = cross(a.omega, n);
    const Vector3<double> from = a.motion().point(joint.point), to = b.motion().point(joint.second_point);
    const Vector3<double> apart = to - from;
    const auto velocity_of = [](const RigidPart::RigidState& body, const Vector3<double>& x) {
      return body.velocity + cross(body.omega, x - body.motion().point(body.centre));
    };
    const Vector3<double> moving_apart = velocity_of(b, to) - velocity_of(a, from);
    double rate = 0.0;
    const std::size_t first = result.size();
    if (joint.angle != nullptr) {
      result.push_back(angle_of_joint(joint, bodies));
      rate = dot(b.omega - a.omega, n);
    }
    if (joint.type == JointType::distance) {
      const double length = norm(apart);
      result.push_back(length - norm(joint.second_point - joint.point));
      rate = dot(apart, moving_apart) / length;
    } else if (has_travel(joint.type)) {
      result.push_back(dot(apart, n));
      rate = dot(moving_apart, n) + dot(apart, n_rate);
    }
    if ((joint.angle != nullptr) != has_travel(joint.type)) result.push_back(rate);
    const double coordinate = result.size() > first ? result[first] : 0.0;
    for (const JointLaw& law : model_.laws_of_joint(j)) {
      result.push_back(joint_effort(law, coordinate, rate, at.time, at.load_factor).effort);
    }
    const JointReaction reaction = j < reactions.size() ? reactions[j] : JointReaction{};
    add(reaction.force);
    add(reaction.torque);
  }
  return result;
}

}  // namespace pliant
