#include "model/mechanisms.hpp"

#include "base/text.hpp"
#include "input/analysis.hpp"
#include "mesh/disjoint_sets.hpp"
#include "model/rods.hpp"
#include "model/unresisted_motions.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "petsc/ghosted.hpp"

#include <algorithm>
#include <cmath>
#include <eigen3/Eigen/Eigenvalues>
#include <map>
#include <optional>

#include <fmt/format.h>

namespace pliant {
namespace {

/// The cosine of an angle that counts as right.
constexpr double right_angle = 1e-6;

/// The scalar equations of a joint.
class Equations {
 public:
  Equations(const JointConfig& joint, const Vector3<double>& axis)
      : joint_(joint), point_(joint.point), axis_(axis), across_(across(axis)) {}

  std::vector<std::variant<Coincidence, Perpendicularity, Travel, Turn, Distance>> operator()() {
    switch (joint_.type) {
      case JointType::fixed:
        meet();
        align();
        break;
      case JointType::ball:
        meet();
        break;
      case JointType::hinge:
        meet();
        keep_axis();
        if (const Expression* angle = motion()) add(Turn{across_[0], across_[1], *angle});
        break;
      case JointType::slider:
        align();
        stay_on_axis();
        if (const Expression* travel = motion()) add(Travel{point_, axis_, *travel});
        break;
      case JointType::cylindrical:
        keep_axis();
        stay_on_axis();
        break;
      case JointType::universal:
        meet();
        add(Perpendicularity{axis_, unit(*joint_.second_axis)});
        break;
      case JointType::planar:
        keep_axis();
        add(Travel{point_, axis_, std::nullopt});
        break;
      case JointType::distance: {
        const Vector3<double> b = *joint_.second_point;
        add(Distance{point_, b, norm(b - point_), joint_.motion});
        break;
      }
    }
    return std::move(equations_);
  }

 private:
  using Equation = std::variant<Coincidence, Perpendicularity, Travel, Turn, Distance>;
  void add(Equation equation) { equations_.push_back(std::move(equation)); }
  const Expression* motion() const { return joint_.motion ? &*joint_.motion : nullptr; }
  void meet() {
    for (std::size_t i = 0; i < 3; ++i) {
      Vector3<double> normal{};
      normal[i] = 1.0;
      add(Coincidence{point_, normal});
    }
  }
  void align() {
    keep_axis();
    add(Perpendicularity{across_[0], across_[1]});
  }
  /// The second body's axis stays that of the first.
  void keep_axis() {
    for (const auto& direction : across_) add(Perpendicularity{direction, axis_});
  }
  void stay_on_axis() {
    for (const auto& direction : across_) add(Travel{point_, direction, std::nullopt});
  }

  const JointConfig& joint_;
  Vector3<double> point_, axis_;
  std::array<Vector3<double>, 2> across_;
  std::vector<Equation> equations_;
};

bool needs_axis(JointType type) {
  return type == JointType::hinge || type == JointType::slider || type == JointType::cylindrical ||
         type == JointType::universal || type == JointType::planar;
}

/// The number of the constraint that makes a part of this name rigid; nothing, with an error, if there is none.
std::optional<std::size_t> find_part(const ConstraintsOnMesh& constraints, const JointConfig& joint, std::size_t side,
                                     Selections& selections) {
  const std::string& name = joint.between[side];
  if (name == "ground") return ModelJoint::ground;
  std::vector<std::string> known{"ground"};
  for (std::size_t c = 0; c < constraints.parts.size(); ++c) {
    const ConstraintConfig& constraint = constraints.config.constraints[c];
    if (!std::holds_alternative<ConstraintConfig::Rigid>(constraint.kind)) continue;
    // A single body without a volume is the whole mesh.
    const std::string name_of_part =
        constraint.part.kind == Selection::Kind::everything ? "body" : constraint.part.name;
    if (name_of_part != name) {
      if (!name_of_part.empty()) known.push_back(name_of_part);
      continue;
    }
    if (constraints.parts[c].rotation) return c;
    selections.report(joint.where, fmt::format("joint '{}' connects '{}', whose rotation a constraint gives: name "
                                               "`ground` if it is held, or leave the rotation `free` and move it by "
                                               "the joint's `motion`",
                                               joint.name, name));
    return std::nullopt;
  }
  const auto is_it = [&](const BodyConfig& body) { return body.part.name == name; };
  const bool is_soft =
      std::ranges::any_of(constraints.config.bodies, is_it) || selections.has_group(Selection::Kind::surface, name);
  selections.report(
      joint.where,
      fmt::format(
          "joint '{}' connects '{}', which is not a rigid body, nor a part with a constraint `rigid`{}{}; there "
          "are: {}",
          joint.name, name, did_you_mean(name, known),
          is_soft ? " (a soft body is joined by a surface of it: give that to a rigid body as `attached: "
                    "[surface]` or `coupled: [surface]`, and name the rigid body here)"
                  : "",
          joined(known)));
  return std::nullopt;
}

/// The joint's axis, zero if it has none; nothing, with an error, if it is wrong.
std::optional<Vector3<double>> find_axis(const JointConfig& joint, Selections& selections) {
  if (joint.type == JointType::fixed) return Vector3<double>{0.0, 0.0, 1.0};
  if (!needs_axis(joint.type)) return Vector3<double>{};
  const Vector3<double> axis = unit(*joint.axis);
  if (joint.type == JointType::universal && std::abs(dot(axis, unit(*joint.second_axis))) > right_angle) {
    selections.report(joint.where,
                      fmt::format("the axes of joint '{}' must be at right angles at the start", joint.name));
    return std::nullopt;
  }
  return axis;
}

/// One flag per constraint: whether a rigid part has nodes in cells that it does not fill, or follows a surface of
/// other bodies. Collective.
std::vector<char> parts_held_by_soft_bodies(const ConstraintsOnMesh& constraints) {
  std::vector<double> held(constraints.parts.size(), 0.0);
  if (constraints.config.joints.empty()) return std::vector<char>(held.size(), 0);
  const NodeLayout& layout = constraints.layout;
  const Handle<Vec> numbers = make_vector(layout);
  {
    const ArrayView of_entries(numbers.get());
    for (std::size_t c = 0; c < constraints.parts.size(); ++c) {
      if (!constraints.parts[c].rotation) continue;
      for (const PetscInt node : constraints.parts[c].nodes) of_entries[3 * node] = static_cast<double>(c + 1);
    }
  }
  update_ghosts(numbers.get());
  const ConstGhostedView of_nodes(numbers.get());
  for (PetscInt cell = 0; cell < layout.num_owned_cells; ++cell) {
    const auto nodes = layout.nodes_of_cell(cell);
    const auto part_of = [&](PetscInt n) { return static_cast<std::size_t>(of_nodes.span()[3 * n]); };
    const bool is_filled = std::ranges::all_of(nodes, [&](PetscInt n) { return part_of(n) == part_of(nodes[0]); });
    if (is_filled) continue;
    for (const PetscInt n : nodes) {
      if (part_of(n) > 0) held[part_of(n) - 1] = 1.0;
    }
  }
  sum_in_place(layout.comm, held);
  std::vector<char> result;
  for (std::size_t c = 0; c < held.size(); ++c) {
    const std::string& name = constraints.config.constraints[c].part.name;
    const auto body = std::ranges::find(constraints.config.rigid_bodies, name, &RigidBodyConfig::name);
    const bool is_coupled = body != constraints.config.rigid_bodies.end() && !body->coupled.empty();
    result.push_back(held[c] > 0.0 || is_coupled ? 1 : 0);
  }
  return result;
}

/// The joints of the input, then the mechanisms that they make.
class RigidSystemBuilder {
 public:
  RigidSystemBuilder(const ConstraintsOnMesh& constraints, Selections& selections)
      : constraints_(constraints),
        selections_(selections),
        groups_(constraints.parts.size()),
        are_held_(parts_held_by_soft_bodies(constraints)) {}

  RigidSystem operator()() {
    for (const JointConfig& joint : constraints_.config.joints) add(joint);
    selections_.throw_if_errors();
    // Parts of each mechanism, by its first part; those without joints are alone.
    std::map<std::size_t, std::vector<std::size_t>> members;
    for (std::size_t c = 0; c < constraints_.parts.size(); ++c) {
      if (constraints_.parts[c].rotation) members[groups_.root(c)].push_back(c);
    }
    for (const auto& [root, parts] : members) connect(parts, joints_of(root));
    selections_.throw_if_errors();
    return std::move(system_);
  }

 private:
  void add(const JointConfig& joint) {
    const auto first = find_part(constraints_, joint, 0, selections_);
    const auto second = find_part(constraints_, joint, 1, selections_);
    const auto axis = find_axis(joint, selections_);
    if (!first || !second || !axis) return;
    if (*first == *second) {
      selections_.report(joint.where,
                         fmt::format("joint '{}' connects '{}' with itself", joint.name, joint.between[0]));
      return;
    }
    ModelJoint& added = system_.joints.emplace_back();
    added.name = joint.name;
    added.type = joint.type;
    added.point = joint.point;
    added.second_point = joint.type == JointType::distance ? *joint.second_point : joint.point;
    added.axis = *axis;
    const bool turns = joint.type == JointType::hinge || joint.type == JointType::cylindrical;
    if (turns) added.angle = std::make_shared<double>(0.0);
    added.parts = {*first, *second};
    configs_.push_back(&joint);
    if (*first != ModelJoint::ground && *second != ModelJoint::ground) groups_.join(*first, *second);
  }

  std::vector<std::size_t> joints_of(std::size_t root) {
    std::vector<std::size_t> joints;
    for (std::size_t j = 0; j < system_.joints.size(); ++j) {
      const auto& [first, second] = system_.joints[j].parts;
      if (groups_.root(first == ModelJoint::ground ? second : first) == root) joints.push_back(j);
    }
    return joints;
  }

  void connect(const std::vector<std::size_t>& parts, const std::vector<std::size_t>& joints) {
    std::vector<std::unique_ptr<RigidPart>> rigid;
    std::vector<char> are_held;
    for (const std::size_t c : parts) {
      are_held.push_back(are_held_[c]);
      const ConstraintPart& part = constraints_.parts[c];
      rigid.push_back(
          std::make_unique<RigidPart>(constraints_.layout, part.nodes, *part.displacement.rigid, *part.rotation));
      if (joints.empty() || !rigid.back()->is_plane()) continue;
      const ConstraintConfig& constraint = constraints_.config.constraints[c];
      selections_.report(constraint.where, fmt::format("{} lies in a plane, and joints need nodes off it: attach "
                                                       "it to one of `rigid_bodies`, or make a volume rigid",
                                                       describe(constraint.part)));
    }
    if (joints.empty()) {
      const auto n = static_cast<Eigen::Index>(rigid.front()->hosts().size());
      require_mass(parts, joints, JointSystem::Matrix::Identity(n, n));
      require_resistance(parts, nullptr, static_cast<Eigen::Index>(rigid.front()->hosts().size()) < 6);
      for (auto& part : rigid) system_.dependents.push_back(std::move(part));
      return;
    }
    selections_.throw_if_errors();
    std::vector<JointEquation> equations;
    for (std::size_t k = 0; k < joints.size(); ++k) {
      ModelJoint& joint = system_.joints[joints[k]];
      joint.number = k;
      for (std::size_t side = 0; side < 2; ++side) {
        const std::size_t part = joint.parts[side];
        joint.bodies[side] = part == ModelJoint::ground
                                 ? JointEquation::ground
                                 : static_cast<int>(std::ranges::find(parts, part) - parts.begin());
      }
      for (auto& kind : Equations(*configs_[joints[k]], joint.axis)()) {
        equations.push_back({std::move(kind), joint.bodies, k});
      }
    }
    const bool is_on_ground =
        std::ranges::any_of(equations, [](const JointEquation& of) { return of.bodies[0] < 0 || of.bodies[1] < 0; });
    auto mechanism = std::make_unique<Mechanism>(constraints_.layout, std::move(rigid), are_held, std::move(equations));
    report_dependent(*mechanism, joints);
    require_mass(parts, joints, mechanism->free_motions());
    require_resistance(parts, mechanism.get(), is_on_ground);
    for (const std::size_t j : joints) system_.joints[j].mechanism = mechanism.get();
    system_.dependents.push_back(std::move(mechanism));
  }

  /// The rotation of a body of its own mass is that of nodes at the distance of its radius of gyration: their rounding
  /// errors are those of their places.
  void require_radius_of_gyration(const RigidBodyConfig& body, const std::vector<std::size_t>& joints) {
    constexpr double least = 1e-7;  // relative to the reach: angles with an error of 1e-9
    const auto length = [](const std::array<double, 3>& x) { return std::hypot(x[0], x[1], x[2]); };
    double reach = length(body.center);
    for (const std::size_t j : joints) reach = std::max(reach, length(configs_[j]->point));
    const auto& moments = body.inertia.moments;
    const double largest = *std::max_element(moments.begin(), moments.begin() + 3);
    const double radius = std::sqrt(largest / body.mass);
    if (!(largest > 0.0) || radius > least * reach) return;
    selections_.report(
        body.inertia.where,
        fmt::format("the moment of inertia of '{}' is that of a body of {:.1g} m at distances of {:.2g} m, "
                    "whose rotation is lost in rounding errors; give at least {:.1g} kg m^2",
                    body.name, radius, reach, 10.0 * least * least * reach * reach * body.mass));
  }

  /// In dynamics every free motion needs a mass: a mass point has no rotation that forces determine. `free`: columns in
  /// the unknowns of all parts, three translations [m] and three rotations times a length of each.
  void require_mass(const std::vector<std::size_t>& parts, const std::vector<std::size_t>& joints,
                    const JointSystem::Matrix& free) {
    if (analysis_of(constraints_.config) != Analysis::dynamic || free.cols() == 0) return;
    constexpr Eigen::Index unknowns_of_part = 6;
    if (free.rows() != unknowns_of_part * static_cast<Eigen::Index>(parts.size()))
      return;  // parts whose motion is prescribed
    JointSystem::Matrix mass = JointSystem::Matrix::Identity(free.rows(), free.rows());
    std::vector<std::string> names;
    for (std::size_t p = 0; p < parts.size(); ++p) {
      const std::string& name = constraints_.config.constraints[parts[p]].part.name;
      const auto& bodies = constraints_.config.rigid_bodies;
      const auto body = std::ranges::find(bodies, name, &RigidBodyConfig::name);
      if (body == bodies.end() || !body->attached.empty() || !body->coupled.empty()) continue;
      if (!sections_held_by(constraints_.config, name).empty()) continue;
      require_radius_of_gyration(*body, joints);
      const auto& [xx, yy, zz, xy, yz, zx] = body->inertia.moments;
      const double largest = xx + yy + zz;
      JointSystem::Matrix inertia(3, 3);
      inertia << xx, xy, zx, xy, yy, yz, zx, yz, zz;
      const auto first = unknowns_of_part * static_cast<Eigen::Index>(p) + 3;
      mass.block(first, first, 3, 3) = largest > 0.0 ? JointSystem::Matrix(inertia / largest) : inertia;
      names.push_back("'" + name + "'");
    }
    if (names.empty()) return;
    const Eigen::SelfAdjointEigenSolver<JointSystem::Matrix> solver(free.transpose() * mass * free);
    constexpr double none = 1e-10;
    if (solver.eigenvalues()[0] > none) return;
    selections_.report(
        constraints_.parts[parts.front()].where,
        fmt::format("a rotation of {} has no moment of inertia, and no joint prevents it: forces do not "
                    "determine it; give a moment of inertia, however small, or a joint that leaves less free",
                    joined(names)));
  }

  void require_resistance(const std::vector<std::size_t>& parts, const Mechanism* mechanism, bool is_on_ground) {
    ConnectedBodies bodies{{}, mechanism, is_on_ground};
    for (const std::size_t c : parts) bodies.names.push_back(constraints_.config.constraints[c].part.name);
    if (const auto found = find_unresisted_motion(constraints_.config, bodies)) {
      selections_.report(found->where, found->message);
    }
  }

  void report_dependent(const Mechanism& mechanism, const std::vector<std::size_t>& joints) {
    const auto [dependent, number] = mechanism.dependent_joints();
    if (dependent.empty()) return;
    std::vector<std::string> names;
    for (const std::size_t j : dependent) names.push_back("'" + system_.joints[joints[j]].name + "'");
    const std::string what =
        names.size() == 1
            ? fmt::format("joint {} repeats or contradicts what already holds its bodies", names[0])
            : fmt::format(
                  "joints {} repeat or contradict one another: {} that they forbid {} forbidden already; let them "
                  "leave as many more free: `cylindrical` or `universal` instead of `hinge` leaves one, `ball` "
                  "two, and a plane loop of hinges, with 3 too many, needs one `ball` and one `cylindrical`",
                  joined(names), number == 1 ? "a motion" : fmt::format("{} motions", number),
                  number == 1 ? "is" : "are");
    selections_.report(configs_[joints[dependent.front()]]->where, what);
  }

  const ConstraintsOnMesh& constraints_;
  Selections& selections_;
  DisjointSets groups_;
  std::vector<char> are_held_;
  RigidSystem system_;
  std::vector<const JointConfig*> configs_;  // of the system's joints
};

}  // namespace

std::array<Vector3<double>, 2> across(const Vector3<double>& axis) {
  std::size_t least = 0;
  for (std::size_t i = 1; i < 3; ++i) {
    if (std::abs(axis[i]) < std::abs(axis[least])) least = i;
  }
  Vector3<double> other{};
  other[least] = 1.0;
  const Vector3<double> e = unit(cross(axis, other));
  return {e, cross(axis, e)};
}

RigidSystem make_rigid_system(const ConstraintsOnMesh& constraints, Selections& selections) {
  return RigidSystemBuilder(constraints, selections)();
}

}  // namespace pliant
