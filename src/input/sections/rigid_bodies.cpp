#include "input/sections/rigid_bodies.hpp"

#include "input/formats.hpp"
#include "input/sections/body_point.hpp"

namespace pliant {
namespace {

/// Three principal moments, or six numbers.
Format<RigidBodyConfig::Inertia> inertia() {
  const auto principal = array_of<3>(quantity("kg*m^2", Range::at_least(0)));
  const auto full = array_of<6>(quantity("kg*m^2"));
  Format<RigidBodyConfig::Inertia> format{
      "list of 3 numbers (principal moments) or of 6 (xx, yy, zz, xy, yz, zx) [kg m^2]",
      either_schema(principal.schema, full.schema),
      {},
      {}};
  format.read = [principal, full](const InputNode& node, const std::string& name, Diagnostics& diagnostics,
                                  RigidBodyConfig::Inertia& into) {
    into.where = node.where;
    if (node.kind == InputNode::Kind::list && node.children.size() == 6) {
      return full.read(node, name, diagnostics, into.moments);
    }
    const std::string wanted = "a list of 3 principal moments or of 6 numbers xx, yy, zz, xy, yz, zx";
    if (node.kind != InputNode::Kind::list) return refuse(node, name, wanted, diagnostics);
    if (node.children.size() != 3) {
      diagnostics.add(node.where, "'" + name + "' must be " + wanted + ", not of " +
                                      std::to_string(node.children.size()) + why_split(node));
      return false;
    }
    std::array<double, 3> moments{};
    if (!principal.read(node, name, diagnostics, moments)) return false;
    std::ranges::copy(moments, into.moments.begin());
    return true;
  };
  format.write = [full](const RigidBodyConfig::Inertia& from) { return full.write(from.moments); };
  return format;
}

/// By what a joint moves, which decides the units of its quantities.
enum class Movement { angle, travel, either };

/// Units of a quantity of joints that move by an angle, and by a travel.
struct JointUnit {
  const char *of_angle, *of_travel;
};
constexpr JointUnit coordinate_unit{"rad", "m"}, rate_unit{"rad/s", "m/s"}, effort_unit{"N*m", "N"},
    stiffness_unit{"N*m/rad", "N/m"}, damping_unit{"N*m*s/rad", "N*s/m"};

/// A value of the one format or of the other.
template <class V>
Format<V> either(const Format<V>& one, const Format<V>& other, const std::string& type) {
  Format<V> format{type, one.schema, {}, one.write};
  format.read = [one, other](const InputNode& node, const std::string& name, Diagnostics& diagnostics, V& into) {
    Diagnostics ignored;
    return one.read(node, name, ignored, into) || other.read(node, name, diagnostics, into);
  };
  return format;
}

Format<double> quantity_of(Movement movement, const JointUnit& unit, const Range& range = {}) {
  const auto of_angle = quantity(unit.of_angle, range), of_travel = quantity(unit.of_travel, range);
  if (movement == Movement::angle) return of_angle;
  if (movement == Movement::travel) return of_travel;
  // The range once, at the end.
  return either(of_angle, of_travel, quantity(unit.of_angle).type + " or " + of_travel.type);
}

Format<Expression> expression_of(Movement movement, const JointUnit& unit) {
  const auto of_angle = expression(unit.of_angle, Variables::time);
  const auto of_travel = expression(unit.of_travel, Variables::time);
  if (movement == Movement::angle) return of_angle;
  if (movement == Movement::travel) return of_travel;
  return either(of_angle, of_travel, quantity(unit.of_angle).type + ", " + of_travel.type);
}

Section<JointConfig::Motor> motor_keys(Movement movement) {
  using M = JointConfig::Motor;
  return {{
              field("target", &M::target, expression_of(movement, coordinate_unit), "angle or travel that it aims at")
                  .otherwise("0"),
              field("stiffness", &M::stiffness, quantity_of(movement, stiffness_unit, Range::at_least(0)),
                    "effort per difference from the target")
                  .otherwise("0"),
              field("damping", &M::damping, quantity_of(movement, damping_unit, Range::at_least(0)),
                    "effort per difference from the target's rate")
                  .otherwise("0"),
              field("limit", &M::limit, quantity_of(movement, effort_unit, Range::above(0)),
                    "largest effort, reached smoothly")
                  .otherwise_in_words("none"),
              field("effort", &M::effort, expression_of(movement, effort_unit), "given torque or force, in addition")
                  .otherwise("0"),
          },
          {{{"stiffness", "damping", "effort"}, KeyGroup::Need::at_least_one}}};
}

Section<JointConfig::Spring> joint_spring_keys(Movement movement) {
  using S = JointConfig::Spring;
  return {{
      field("stiffness", &S::stiffness, quantity_of(movement, stiffness_unit, Range::above(0)),
            "effort per angle or travel")
          .required(),
      field("rest", &S::rest, quantity_of(movement, coordinate_unit), "angle or travel without effort").otherwise("0"),
  }};
}

Section<JointConfig::Bearing> bearing_keys() {
  using B = JointConfig::Bearing;
  return {{
      field("friction", &B::friction, quantity("1", Range::at_least(0)), "coefficient of friction (Coulomb)")
          .required(),
      field("radius", &B::radius, quantity("m", Range::above(0)),
            "radius of a hinge's pin, at which it slides; of a slider: distance from the axis at which torques about "
            "it are carried")
          .otherwise_in_words("a hinge needs one; a slider's friction does not depend on torques about its axis"),
      field("length", &B::length, quantity("m", Range::above(0)),
            "distance along the axis of the two places that carry the load; torques across the axis load them")
          .otherwise_in_words("none: torques across the axis cause no friction"),
  }};
}

Section<RigidBodyConfig::Surface> surface_keys() {
  using S = RigidBodyConfig::Surface;
  return {{
      field(
          "file", &S::file, text(),
          "closed surface (.stl), geometry or mesh (.msh), relative to the input file, where the body is at the start")
          .required(),
      field("scale", &S::scale, quantity("1", Range::above(0)), "factor of the file's coordinates").otherwise("1"),
      field("size", &S::size, quantity("m", Range::above(0)), "size of the elements that gmsh makes")
          .otherwise_in_words("that of the triangles"),
  }};
}

Section<JointConfig> joint_keys(Movement movement) {
  using J = JointConfig;
  return {
      {
          field("name", &J::name, column_name(), "prefix of its columns in history.csv").required(),
          field("type", &J::type,
                choice_of<JointType>(
                    {joint_types.begin(), joint_types.end()},
                    " (revolute: 'hinge'; prismatic, translational: 'slider'; spherical: 'ball'; welded: 'fixed')"),
                "fixed: no relative motion; ball: about `point`; hinge: about the axis; slider: along it; "
                "cylindrical: both; universal: about `axis`, which moves with the first body, and `second_axis`, "
                "which moves with the second; planar: in the plane across the axis; distance: of `point` on the "
                "first body and `second_point` on the second")
              .required(),
          field("between", &J::between, array_of<2>(text()),
                "two of: names of rigid bodies, volumes or surfaces with a constraint `rigid`, `ground`")
              .required(),
          field("point", &J::point, array_of<3>(quantity("m")), "place of the joint at the start").required(),
          field("axis", &J::axis, direction_of_any_length(), "direction of the axis at the start")
              .only_with({{"type", "hinge"},
                          {"type", "slider"},
                          {"type", "cylindrical"},
                          {"type", "universal"},
                          {"type", "planar"}}),
          field("second_axis", &J::second_axis, direction_of_any_length(), "direction at the start, across `axis`")
              .only_with({{"type", "universal"}}),
          field("second_point", &J::second_point, array_of<3>(quantity("m")), "place on the second body at the start")
              .only_with({{"type", "distance"}}),
          field("motion", &J::motion, expression_of(movement, coordinate_unit),
                "given angle of a hinge, travel of a slider or change of a distance")
              .otherwise_in_words("none: it follows from the forces")
              .only_with({{"type", "hinge"}, {"type", "slider"}, {"type", "distance"}}),
          field("motor", &J::motor, map_of(motor_keys(movement)),
                "motor: proportional and derivative control of the angle or travel, or a given effort")
              .otherwise_in_words("none")
              .only_with({{"type", "hinge"}, {"type", "slider"}}),
          field("spring", &J::spring, map_of(joint_spring_keys(movement)), "spring that acts on the angle or travel")
              .otherwise_in_words("none")
              .only_with({{"type", "hinge"}, {"type", "slider"}}),
          field("damping", &J::damping, quantity_of(movement, damping_unit, Range::at_least(0)),
                "effort per rate of the angle or travel")
              .otherwise_in_words("0")
              .only_with({{"type", "hinge"}, {"type", "slider"}}),
          field("limits", &J::limits, array_of<2>(quantity_of(movement, coordinate_unit)),
                "smallest and largest angle or travel: stops that give way by little")
              .otherwise_in_words("none")
              .only_with({{"type", "hinge"}, {"type", "slider"}}),
          field("limit_stiffness", &J::limit_stiffness, quantity_of(movement, stiffness_unit, Range::above(0)),
                "effort of a stop per angle or travel beyond it")
              .otherwise_in_words("what stops the bodies within a few time steps")
              .only_with({{"limits"}}),
          field("friction", &J::friction, quantity_of(movement, effort_unit, Range::at_least(0)),
                "effort of dry friction against the motion")
              .otherwise_in_words("0")
              .only_with({{"type", "hinge"}, {"type", "slider"}}),
          field("bearing", &J::bearing, map_of(bearing_keys()),
                "dry friction that follows the force and the torque which the joint carries")
              .otherwise_in_words("none")
              .only_with({{"type", "hinge"}, {"type", "slider"}}),
          field("stick_rate", &J::stick_rate, quantity_of(movement, rate_unit, Range::above(0)),
                "rate at which dry friction reaches 76 % of its effort")
              .otherwise("0.001")
              .only_with({{"friction"}, {"bearing"}})
              .left_out_if([](const J& joint) { return !joint.friction && !joint.bearing; }),
      },
      {{{"motion", "motor"}, KeyGroup::Need::at_most_one}, {{"motion", "limits"}, KeyGroup::Need::at_most_one}},
      &J::where};
}

}  // namespace

Section<RigidBodyConfig> rigid_body_keys() {
  using R = RigidBodyConfig;
  return {{
              field("name", &R::name, column_name(), "name in joints and constraints, and prefix of its columns")
                  .required(),
              field("mass", &R::mass, quantity("kg", Range::at_least(0)),
                    "mass of the body; needed unless something is attached to it or coupled with it")
                  .otherwise("0"),
              field("inertia", &R::inertia, inertia(), "moments of inertia about the center").otherwise("[0, 0, 0]"),
              field("center", &R::center, array_of<3>(quantity("m")),
                    "center of mass; `initial.displacement` moves it, as it moves the mesh")
                  .required(),
              field("velocity", &R::velocity, array_of<3>(quantity("m/s")), "velocity of the center at the start")
                  .otherwise_in_words("`initial.velocity`"),
              field("angular_velocity", &R::angular_velocity, array_of<3>(quantity("rad/s")),
                    "angular velocity at the start; where it is not 0, the body does not turn with `initial.velocity` "
                    "as well")
                  .otherwise("[0, 0, 0]"),
              field("surface", &R::surface, map_of(surface_keys()), "shape of the body, with which it touches others")
                  .otherwise_in_words("none: it touches nothing"),
              field("attached", &R::attached, list_of(name_of_part(), 1),
                    "names of surfaces of other bodies that move with it, rigidly (RBE2)")
                  .otherwise_in_words("none"),
              field("coupled", &R::coupled, list_of(name_of_part(), 1),
                    "names of surfaces of other bodies whose mean motion it follows, and which stay free to deform "
                    "(RBE3)")
                  .otherwise_in_words("none"),
              field("coupling_stiffness", &R::coupling_stiffness, quantity("N/m", Range::above(0)),
                    "force per distance between the body and the mean of a coupled surface")
                  .otherwise_in_words("1000 times Young's modulus times the root of the area")
                  .only_with({{"coupled"}}),
          },
          {},
          &R::where};
}

Format<JointConfig> joint() {
  const auto of_angle = map_of(joint_keys(Movement::angle)), of_travel = map_of(joint_keys(Movement::travel));
  Format<JointConfig> format = map_of(joint_keys(Movement::either));
  format.read = [of_angle, of_travel, of_either = format.read](const InputNode& node, const std::string& name,
                                                               Diagnostics& diagnostics, JointConfig& into) {
    const InputNode* type = node.find("type");
    if (type != nullptr && type->text == "hinge") return of_angle.read(node, name, diagnostics, into);
    if (type != nullptr && (type->text == "slider" || type->text == "distance")) {
      return of_travel.read(node, name, diagnostics, into);
    }
    return of_either(node, name, diagnostics, into);
  };
  return format;
}

Section<SpringConfig> spring_keys() {
  using S = SpringConfig;
  return {{
              field("name", &S::name, column_name(), "prefix of its columns in history.csv").required(),
              field("points", &S::points, array_of<2>(body_point()), "its ends at the start").required(),
              field("stiffness", &S::stiffness, quantity("N/m", Range::at_least(0)), "force per change of the length")
                  .otherwise("0"),
              field("rest", &S::rest, quantity("m", Range::at_least(0)), "length without force")
                  .otherwise_in_words("the length in the mesh"),
              field("damping", &S::damping, quantity("N*s/m", Range::at_least(0)), "force per rate of the length")
                  .otherwise("0"),
              field("tension_only", &S::is_tension_only, truth(),
                    "whether it is slack, without force, below its length at rest")
                  .otherwise("false"),
          },
          {},
          &S::where};
}

}  // namespace pliant
