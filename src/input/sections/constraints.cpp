#include "input/sections/constraints.hpp"

#include "input/alternatives.hpp"

namespace pliant {
namespace {

using SelectionKind = Selection::Kind;
using AboutAxis = RotationConfig::AboutAxis;
using Rigid = ConstraintConfig::Rigid;

Section<AboutAxis> axis_keys() {
  return {{
      field("axis", &AboutAxis::axis, direction_of_any_length(), "direction of the axis through `center`").required(),
      field("angle", &AboutAxis::angle, expression_or_free("rad", Variables::time),
            "angle of rotation about it, by the right-hand rule; `free`: a hinge")
          .required(),
  }};
}

Format<RotationConfig> rotation() {
  const auto by_name = choice({"free", "fixed"});
  const auto by_keys = map_of(axis_keys());
  Format<RotationConfig> format{by_name.type + ", or with the keys below",
                                either_schema(by_name.schema, by_keys.schema),
                                {},
                                {},
                                by_keys.children,
                                by_keys.groups};
  format.read = [by_name, by_keys](const InputNode& node, const std::string& name, Diagnostics& diagnostics,
                                   RotationConfig& into) {
    into.where = node.where;
    if (node.kind == InputNode::Kind::map) {
      return by_keys.read(node, name, diagnostics, into.kind.emplace<AboutAxis>());
    }
    std::string word;
    if (!by_name.read(node, name, diagnostics, word)) return false;
    if (word == "fixed") into.kind = RotationConfig::Fixed{};
    return true;
  };
  format.write = [by_name, by_keys](const RotationConfig& r) {
    if (const auto* about = std::get_if<AboutAxis>(&r.kind)) return by_keys.write(*about);
    return by_name.write(std::holds_alternative<RotationConfig::Fixed>(r.kind) ? "fixed" : "free");
  };
  return format;
}

Section<Rigid> rigid_keys() {
  return {{
      field("translation", &Rigid::translation, array_of<3>(expression_or_free("m", Variables::time)),
            "displacement of the center; a component `free` follows from the forces")
          .otherwise("[free, free, free]"),
      field("rotation", &Rigid::rotation, rotation(),
            "rotation about the center; `free`: it follows from the forces; `fixed`: none")
          .otherwise("free"),
      field("center", &Rigid::center, array_of<3>(quantity("m")), "reference position of the center")
          .otherwise_in_words("that of one of `rigid_bodies`, or the centroid of the volume or surface, else the mean "
                              "of the nodes; `pliant check` shows it"),
  }};
}

Section<EquationTermConfig> term_keys() {
  using Term = EquationTermConfig;
  return {{
              selector<Term>("surface", SelectionKind::surface, "nodes of this surface"),
              selector<Term>("volume", SelectionKind::volume, "nodes of this volume"),
              selector<Term>("curve", SelectionKind::curve, "nodes of this curve"),
              selector<Term>("point", SelectionKind::point, "nodes of this point group"),
              selector<Term>("box", SelectionKind::box, "nodes inside this box"),
              selector<Term>("where", SelectionKind::where, "nodes whose reference position satisfies this condition"),
              field("component", &Term::component, choice_of<int>({{"x", 0}, {"y", 1}, {"z", 2}}),
                    "component of the displacement; its mean over several nodes")
                  .required(),
              field("coefficient", &Term::coefficient, quantity("1"), "factor of the term").otherwise("1"),
          },
          {{{"surface", "volume", "curve", "point", "box", "where"}}},
          &Term::where};
}

constexpr auto kind = &ConstraintConfig::kind;

/// The only value of `symmetry`.
Format<ConstraintConfig::Symmetry> plane() {
  return choice_of<ConstraintConfig::Symmetry>({{"plane", {}}});
}

}  // namespace

Section<ConstraintConfig> constraint_keys() {
  using C = ConstraintConfig;
  using Need = KeyGroup::Need;
  const auto place_and_time = Variables::space_and_time;
  return {{
              field("name", &C::name, column_name(),
                    "prefix of the columns of its reaction in history.csv; constraints with the same name have them "
                    "in common")
                  .otherwise_in_words("its group's, else constraint1, constraint2, ... by its place in the list"),
              selector<C>("surface", SelectionKind::surface, "nodes of this surface"),
              selector<C>("volume", SelectionKind::volume, "nodes of this volume"),
              selector<C>("curve", SelectionKind::curve, "nodes of this curve"),
              selector<C>("point", SelectionKind::point, "nodes of this point group"),
              selector<C>("box", SelectionKind::box, "nodes inside this box"),
              selector<C>("where", SelectionKind::where, "nodes whose reference position satisfies this condition"),
              choosing_field(
                  kind, "displacement", array_of<3>(expression_or_free("m", place_and_time)),
                  "prescribed displacement (Dirichlet boundary condition); a component `free` is not constrained",
                  &C::Displacement::value),
              choosing_field(kind, "symmetry", plane(), "the surface is a plane of symmetry: its nodes stay in it"),
              choosing_field(kind, "normal_displacement", expression("m", place_and_time),
                             "displacement of a plane surface along its outward normal; it may slide in its plane",
                             &C::Normal::displacement),
              choosing_field(kind, "displacement_along", expression("m", place_and_time),
                             "displacement along `direction`; across it the nodes are free", &C::Along::displacement),
              field_of(kind, "direction", direction_of_any_length(), "with displacement_along: the direction",
                       &C::Along::direction)
                  .only_with({{"displacement_along"}}),
              choosing_field(
                  kind, "periodic_with", selection(SelectionKind::surface),
                  "periodic boundary condition: nodes of the two surfaces that a translation maps onto each other have "
                  "the same displacement, except for `difference`",
                  &C::Periodic::partner),
              field_of(kind, "difference", array_of<3>(expression_or_free("m", Variables::time)),
                       "with periodic_with: displacement of `surface` less that of its partner; a component `free` is "
                       "the same for all nodes and follows from the forces",
                       &C::Periodic::difference)
                  .otherwise("[0, 0, 0]")
                  .only_with({{"periodic_with"}}),
              choosing_field(kind, "tied_to", selection(SelectionKind::surface),
                             "tie to a surface whose mesh need not match (mesh tying): the nodes follow its facets",
                             &C::Tied::partner),
              field_of(kind, "tolerance", quantity("m", Range::above(0.0)),
                       "with tied_to: nodes that are farther from that surface stay free", &C::Tied::tolerance)
                  .otherwise_in_words("a tenth of the mean edge of the surface with the longer edges")
                  .only_with({{"tied_to"}}),
              choosing_field(kind, "rigid", map_of(rigid_keys()),
                             "the nodes move as a rigid body, with rotations of any size (kinematic coupling, RBE2)"),
              choosing_field(kind, "equation", list_of(map_of(term_keys()), 1),
                             "multi-point constraint: the sum of these terms is `value`", &C::Equation::terms),
              field_of(kind, "value", expression("m", Variables::time), "with equation: its right-hand side",
                       &C::Equation::value)
                  .otherwise_in_words("0")
                  .only_with({{"equation"}}),
          },
          {{{"displacement", "symmetry", "normal_displacement", "displacement_along", "periodic_with", "tied_to",
             "rigid", "equation"}},
           {{"surface", "volume", "curve", "point", "box", "where"},
            Need::exactly_one,
            {{"displacement"},
             {"displacement_along"},
             {"rigid"},
             {"symmetry"},
             {"normal_displacement"},
             {"periodic_with"},
             {"tied_to"}}}},
          &C::where};
}

}  // namespace pliant
