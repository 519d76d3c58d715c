#include "run/mechanism_drawing.hpp"

#include "model/mechanisms.hpp"
#include "petsc/collective.hpp"
#include "petsc/ghosted.hpp"

#include <algorithm>
#include <limits>

namespace pliant {
namespace {

/// Half the length of a hinge's axis, in diagonals of the model's bounding box.
constexpr double half_axis = 0.075;
/// Half the length of other lines, in those of a hinge's axis.
constexpr double half_slide = 1.5, half_bar = 0.25, half_cross = 0.3;

bool has_axis(JointType type) {
  return type != JointType::fixed && type != JointType::ball && type != JointType::distance;
}

void append(std::vector<double>& numbers, const Vector3<double>& x) {
  numbers.insert(numbers.end(), x.begin(), x.end());
}

/// The diagonal of the box around the nodes and some points [m]. Collective.
double diagonal_of(const NodeLayout& layout, std::span<const double> points, std::span<const ModelJoint> joints) {
  Vector3<double> lower, upper;
  lower.fill(std::numeric_limits<double>::infinity());
  upper.fill(-std::numeric_limits<double>::infinity());
  const auto include = [&](const Vector3<double>& x) {
    for (std::size_t i = 0; i < 3; ++i) {
      lower[i] = std::min(lower[i], x[i]);
      upper[i] = std::max(upper[i], x[i]);
    }
  };
  for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) include(layout.position(n));
  for (std::size_t k = 0; k < points.size(); k += 3) include({points[k], points[k + 1], points[k + 2]});
  for (const ModelJoint& joint : joints) include(joint.point);
  for (double& x : lower) x = minimum(layout.comm, x);
  for (double& x : upper) x = maximum(layout.comm, x);
  return norm(upper - lower);
}

}  // namespace

MechanismDrawing::MechanismDrawing(const Config& config, const Model& model) : model_(model) {
  const NodeLayout& layout = model.layout();
  const std::vector<double> at_rest(3 * static_cast<std::size_t>(layout.num_local_nodes), 0.0);
  for (const ModelTendon& tendon : model.tendons()) {
    add_part(tendon.name, "tendon");
    add_line(places_of(tendon.points, layout, at_rest));
  }
  const auto ends = places_of(model.springs().points, layout, at_rest);
  for (std::size_t k = 0; k < model.springs().names.size(); ++k) {
    add_part(model.springs().names[k], "spring");
    add_line({ends[2 * k], ends[2 * k + 1]});
  }
  for (const ModelRod& rod : model.rods().rods) {
    add_part(rod.name, "rod");
    add_line(places_of(rod.points, layout, at_rest));
  }
  const auto& joints = model.constraints().joints();
  const double size = half_axis * diagonal_of(layout, parts_.points, joints);
  joint_points_.resize(joints.size());
  for (std::size_t j = 0; j < joints.size(); ++j) add_joint(j, config.joints[j], size);
}

std::size_t MechanismDrawing::add_part(const std::string& name, const std::string& kind) {
  parts_.names.push_back(name);
  parts_.kinds.push_back(kind);
  return parts_.names.size() - 1;
}

std::int64_t MechanismDrawing::add_point(const Vector3<double>& X) {
  append(parts_.points, X);
  return std::ssize(parts_.points) / 3 - 1;
}

void MechanismDrawing::add_segment(std::int64_t from, std::int64_t to) {
  parts_.segments.insert(parts_.segments.end(), {from, to});
  parts_.parts.push_back(static_cast<std::int32_t>(parts_.names.size() - 1));
}

void MechanismDrawing::add_line(const std::vector<Vector3<double>>& places) {
  for (std::size_t k = 0; k < places.size(); ++k) {
    const std::int64_t point = add_point(places[k]);
    if (k > 0) add_segment(point - 1, point);
  }
}

void MechanismDrawing::add_line(std::size_t joint, const JointPoint& from, const JointPoint& to) {
  joint_points_[joint].insert(joint_points_[joint].end(), {from, to});
  const std::int64_t first = add_point(from.X);
  add_segment(first, add_point(to.X));
}

void MechanismDrawing::add_joint(std::size_t joint, const JointConfig& config, double size) {
  const ModelJoint& model = model_.constraints().joints()[joint];
  add_part(model.name, name_of(model.type));
  const Vector3<double> place = model.second_point, a = model.axis;
  joint_points_[joint].push_back({1, place});
  parts_.joints.push_back(add_point(place));
  const auto about = [&](std::size_t body, const Vector3<double>& middle, const Vector3<double>& half) {
    add_line(joint, {body, middle - half}, {body, middle + half});
  };
  const auto cross_in_space = [&] {
    for (std::size_t i = 0; i < 3; ++i) {
      Vector3<double> half{};
      half[i] = half_cross * size;
      about(0, place, half);
    }
  };
  switch (model.type) {
    case JointType::fixed:
    case JointType::ball:
      cross_in_space();
      break;
    case JointType::hinge:
      about(0, place, size * a);
      break;
    case JointType::slider:
    case JointType::cylindrical:
      // With the second body, as the dot: on the first one it would stay behind where that is the ground.
      about(1, place, half_slide * size * a);
      for (const double end : {-half_slide, half_slide}) {
        for (const Vector3<double>& e : across(a)) about(1, place + end * size * a, half_bar * size * e);
      }
      break;
    case JointType::universal:
      about(0, place, size * a);
      about(1, place, size * unit(Vector3<double>(*config.second_axis)));
      break;
    case JointType::planar: {
      about(0, place, size * a);
      const auto [e, f] = across(a);
      for (const auto& [middle, half] : {std::pair{e, f}, std::pair{f, e}}) {
        for (const double side : {-size, size}) about(0, place + side * middle, size * half);
      }
      break;
    }
    case JointType::distance:
      add_line(joint, {0, model.point}, {1, place});
      break;
  }
}

MechanismState MechanismDrawing::state(const Instant& at, Vec q, Vec v) const {
  MechanismState state;
  move_lines(at, q, v, state);
  const auto& joints = model_.constraints().joints();
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const auto bodies = joints[j].mechanism->states(joints[j].bodies, q, v);
    for (const JointPoint& point : joint_points_[j]) append(state.points, bodies[point.body].motion().point(point.X));
    append(state.axes, has_axis(joints[j].type) ? bodies[0].motion().direction(joints[j].axis) : Vector3<double>{});
  }
  state.tensions.resize(parts_.parts.size(), 0.0);
  return state;
}

void MechanismDrawing::move_lines(const Instant& at, Vec q, Vec v, MechanismState& state) const {
  const NodeLayout& layout = model_.layout();
  const Handle<Vec> q_here = make_vector(layout), v_here = make_vector(layout);
  check(VecCopy(q, q_here.get()));
  check(VecCopy(v, v_here.get()));
  update_ghosts(q_here.get());
  update_ghosts(v_here.get());
  const ConstGhostedView u(q_here.get()), velocity(v_here.get());
  for (const ModelTendon& tendon : model_.tendons()) {
    for (const Vector3<double>& x : places_of(tendon.points, layout, u.span())) append(state.points, x);
    const auto tensions = tensions_of(tendon, layout, u.span(), velocity.span(), at);
    state.tensions.insert(state.tensions.end(), tensions.begin(), tensions.end());
  }
  for (const Vector3<double>& x : places_of(model_.springs().points, layout, u.span())) append(state.points, x);
  const auto lengths_and_forces = states_of(model_.springs(), layout, u.span(), velocity.span());
  for (std::size_t k = 1; k < lengths_and_forces.size(); k += 2) state.tensions.push_back(lengths_and_forces[k]);
  const auto of_rods = tensions_of(model_.rods(), layout.comm, u.span());
  for (const ModelRod& rod : model_.rods().rods) {
    for (const Vector3<double>& x : places_of(rod.points, layout, u.span())) append(state.points, x);
    const auto first = of_rods.begin() + static_cast<std::ptrdiff_t>(rod.first_segment);
    state.tensions.insert(state.tensions.end(), first, first + static_cast<std::ptrdiff_t>(rod.num_segments()));
  }
}

}  // namespace pliant
