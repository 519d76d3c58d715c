#include "input/sections/constraints.hpp"

namespace pliant {
namespace {

using SelectionKind = Selection::Kind;
using Constraint = ConstraintConfig::Kind;
using Rotation = RotationConfig::Kind;

Section<RotationConfig> axis_keys() {
  return {{
              field("axis", &RotationConfig::axis, direction_of_any_length(), "direction of the axis through `center`")
                  .required(),
              field("angle", &RotationConfig::angle, expression_or_free("rad", Variables::time),
                    "angle of rotation about it, by the right-hand rule; `free`: a hinge")
                  .required(),
          },
          {},
          &RotationConfig::where};
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
      into.kind = Rotation::about_axis;
      return by_keys.read(node, name, diagnostics, into);
    }
    std::string word;
    if (!by_name.read(node, name, diagnostics, word)) return false;
    into.kind = word == "fixed" ? Rotation::fixed : Rotation::free;
    return true;
  };
  format.write = [by_name, by_keys](const RotationConfig& r) {
    if (r.kind == Rotation::about_axis) return by_keys.write(r);
    return by_name.write(r.kind == Rotation::fixed ? "fixed" : "free");
  };
  return format;
}

Section<RigidConfig> rigid_keys() {
  return {{
      field("translation", &RigidConfig::translation, array_of<3>(expression_or_free("m", Variables::time)),
            "displacement of the center; a component `free` follows from the forces")
          .otherwise("[free, free, free]"),
      field("rotation", &RigidConfig::rotation, rotation(),
            "rotation about the center; `free`: it follows from the forces; `fixed`: none")
          .otherwise("free"),
      field("center", &RigidConfig::center, array_of<3>(quantity("m")), "reference position of the center")
          .otherwise_in_words("the mean of the nodes"),
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
              selector<Term>("where", SelectionKind::where, "nodes whose reference position fulfils this"),
              field("component", &Term::component, choice_of<int>({{"x", 0}, {"y", 1}, {"z", 2}}),
                    "component of the displacement; of several nodes their mean")
                  .required(),
              field("coefficient", &Term::coefficient, quantity("1"), "factor of the term").otherwise("1"),
          },
          {{{"surface", "volume", "curve", "point", "box", "where"}}},
          &Term::where};
}

/// What a constraint says, which decides its kind.
Field<ConstraintConfig> saying(Constraint kind, Field<ConstraintConfig> result) {
  result.fallback.reset();  // what is not given decides nothing
  result.read = [kind, read = result.read](const InputNode& node, Diagnostics& diagnostics, ConstraintConfig& into) {
    into.kind = kind;
    read(node, diagnostics, into);
  };
  return std::move(result).left_out_if([kind](const ConstraintConfig& c) { return c.kind != kind; });
}

/// A key that belongs to one kind and does not decide it.
Field<ConstraintConfig> beside(Constraint kind, Field<ConstraintConfig> result) {
  return std::move(result).left_out_if([kind](const ConstraintConfig& c) { return c.kind != kind; });
}

/// `symmetry: plane` keeps no value.
Field<ConstraintConfig> symmetry() {
  struct Holder {
    std::string value = "plane";
  };
  const auto typed =
      field("symmetry", &Holder::value, choice({"plane"}), "the surface is a plane of symmetry: its nodes stay in it");
  Field<ConstraintConfig> result{typed.info};
  result.read = [read = typed.read](const InputNode& node, Diagnostics& diagnostics, ConstraintConfig&) {
    Holder holder;
    read(node, diagnostics, holder);
  };
  result.write = [write = typed.write](const ConstraintConfig&) { return write(Holder{}); };
  return saying(Constraint::symmetry, std::move(result));
}

}  // namespace

Section<ConstraintConfig> constraint_keys() {
  using C = ConstraintConfig;
  using Need = KeyGroup::Need;
  const auto place_and_time = Variables::space_and_time;
  return {
      {
          selector<C>("surface", SelectionKind::surface, "nodes of this surface"),
          selector<C>("volume", SelectionKind::volume, "nodes of this volume"),
          selector<C>("curve", SelectionKind::curve, "nodes of this curve"),
          selector<C>("point", SelectionKind::point, "nodes of this point group"),
          selector<C>("box", SelectionKind::box, "nodes inside this box"),
          selector<C>("where", SelectionKind::where, "nodes whose reference position fulfils this"),
          saying(Constraint::displacement,
                 field("displacement", &C::displacement, array_of<3>(expression_or_free("m", place_and_time)),
                       "prescribed displacement; a component `free` is left alone")),
          symmetry(),
          saying(Constraint::normal, field("normal_displacement", &C::value, expression("m", place_and_time),
                                           "displacement of a plane surface along its outward normal; it may slide "
                                           "in its plane")),
          saying(Constraint::along, field("displacement_along", &C::value, expression("m", place_and_time),
                                          "displacement along `direction`; across it all is free")),
          beside(Constraint::along, field("direction", &C::direction, direction_of_any_length(),
                                          "with displacement_along: the direction")),
          saying(Constraint::periodic,
                 field("periodic_with", &C::partner, selection(SelectionKind::surface),
                       "the surface repeats this one: nodes that a translation carries onto each other move alike, but "
                       "for `difference`")),
          beside(Constraint::periodic,
                 field("difference", &C::difference, array_of<3>(expression_or_free("m", Variables::time)),
                       "with periodic_with: displacement of `surface` less that of its partner; a component `free` is "
                       "the same for all nodes and follows from the forces")
                     .otherwise("[0, 0, 0]")),
          saying(Constraint::rigid, field("rigid", &C::rigid, map_of(rigid_keys()),
                                          "the nodes move as a rigid body, with rotations of any size")),
          saying(Constraint::equation,
                 field("equation", &C::equation, list_of(map_of(term_keys()), 1), "the sum of these terms is `value`")),
          beside(Constraint::equation,
                 field("value", &C::value, expression("m", Variables::time), "with equation: its right-hand side")
                     .otherwise_in_words("0")),
      },
      {{{"displacement", "symmetry", "normal_displacement", "displacement_along", "periodic_with", "rigid",
         "equation"}},
       {{"surface", "volume", "curve", "point", "box", "where"},
        Need::exactly_one,
        {{"displacement"},
         {"displacement_along"},
         {"rigid"},
         {"symmetry"},
         {"normal_displacement"},
         {"periodic_with"}}},
       {{"direction"}, Need::all, {{"displacement_along"}}},
       {{"difference"}, Need::any, {{"periodic_with"}}},
       {{"value"}, Need::any, {{"equation"}}}},
      &C::where};
}

}  // namespace pliant
