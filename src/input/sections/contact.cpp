#include "input/sections/contact.hpp"

#include "base/text.hpp"
#include "input/alternatives.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace pliant {
namespace {

using Side = ObstacleConfig::Side;

Section<ObstacleMotionConfig::Rotation> rotation_keys() {
  using R = ObstacleMotionConfig::Rotation;
  return {{
      field("axis", &R::axis, direction_of_any_length(), "direction of the axis through `center`").required(),
      field("angle", &R::angle, expression("rad", Variables::time), "angle about it, by the right-hand rule")
          .required(),
      field("center", &R::center, array_of<3>(quantity("m")), "a point of the axis; it moves with `translate`")
          .otherwise_in_words("the obstacle's `point`, or the origin"),
  }};
}

Section<ObstacleMotionConfig> motion_keys() {
  using M = ObstacleMotionConfig;
  return {{
      field("translate", &M::translate, array_of<3>(expression("m", Variables::time)), "displacement")
          .otherwise("[0, 0, 0]"),
      field("rotate", &M::rotate, map_of(rotation_keys()), "rotation").otherwise_in_words("none"),
  }};
}

Format<NormalKind> normal_kind() {
  return choice_of<NormalKind>({{"penalty", NormalKind::penalty}, {"barrier", NormalKind::barrier}});
}

Field<ContactPressureConfig> law_key() {
  return field("law", &ContactPressureConfig::law, normal_kind(),
               "pressure as a function of distance: a spring with a rounded kink, or a barrier that nothing can pass")
      .otherwise("penalty");
}

/// The keys of the pressure apart from its law.
std::vector<Field<ContactPressureConfig>> pressure_keys() {
  using P = ContactPressureConfig;
  return {
      field("stiffness", &P::stiffness, quantity("Pa/m", Range::above(0)),
            "pressure per depth of penetration, per reference area; for a barrier its scale")
          .otherwise_in_words("30 shear moduli per size of a facet, body by body"),
      field("width", &P::width, quantity("m", Range::above(0)),
            "half the distance over which the penalty's kink is rounded, or the distance at which the barrier begins")
          .otherwise_in_words("1/50 of the size of a facet, body by body"),
      field("threshold", &P::threshold, quantity("m", Range::at_least(0)),
            "distance from the obstacle at which the spring begins, or at which the barrier is infinite; half of the "
            "thickness of free shells and rods is added to it")
          .otherwise("0"),
  };
}

/// Warns of what is probably a percentage.
Format<double> coefficient_of_friction() {
  constexpr double most = 10.0;  // rubber on rubber has 1 to 2, gels and adhesives up to 5
  Format<double> format = quantity("1", Range::at_least(0));
  format.read = [read = format.read](const InputNode& node, const std::string& name, Diagnostics& diagnostics,
                                     double& into) {
    if (!read(node, name, diagnostics, into)) return false;
    if (into > most) {
      diagnostics.warn(node.where, fmt::format("a coefficient of friction of {:g} is far above that of any materials "
                                               "(rubber: 1 to 2); is {:g} meant, which is {:g} %?",
                                               into, into / 100.0, into));
    }
    return true;
  };
  return format;
}

std::vector<Field<ContactDragConfig>> drag_keys(const std::string& otherwise) {
  using D = ContactDragConfig;
  return {
      field("friction", &D::friction, coefficient_of_friction(), "Coulomb's coefficient of friction")
          .otherwise_in_words(otherwise),
      field("viscous_friction", &D::viscous_friction, quantity("s/m", Range::at_least(0)),
            "increase of the coefficient of friction per sliding velocity")
          .otherwise_in_words(otherwise),
      field("normal_damping", &D::normal_damping, quantity("s/m", Range::at_least(0)),
            "relative increase of the pressure per velocity of approach (Hunt and Crossley)")
          .otherwise_in_words(otherwise),
  };
}

const std::string of_contact = "that of `contact`";

Section<ObstacleConfig> obstacle_keys() {
  using O = ObstacleConfig;
  const NamedAlternatives shape("shape", &O::shape, {"plane", "sphere", "cylinder", "capsule", "box", "surface"});
  std::vector<Field<O>> keys{
      field("name", &O::name, column_name(), "prefix of the obstacle's columns in history.csv").required(),
      shape
          .choice(
              "a plane bounds half of space, a cylinder has flat ends and a capsule round ones, a surface is read from "
              "`file`")
          .required(),
      field("point", &O::point, array_of<3>(quantity("m")),
            "a point of the plane, or the middle of another shape; for a surface the default center of rotation")
          .otherwise("[0, 0, 0]"),
      shape.field("normal", direction_of_any_length(), "direction from a plane towards the bodies, of any length",
                  &O::Plane::normal),
      shape.field("axis", direction_of_any_length(), "axis of a cylinder or capsule", &O::Cylinder::axis,
                  &O::Capsule::axis),
      shape.field("radius", quantity("m", Range::above(0)), "radius of a sphere, cylinder or capsule",
                  &O::Sphere::radius, &O::Cylinder::radius, &O::Capsule::radius),
      shape
          .field("length", quantity("m", Range::above(0)),
                 "length of a cylinder, or of a capsule between the centres of its ends", &O::Cylinder::length,
                 &O::Capsule::length)
          .otherwise_in_words("a cylinder is endless"),
      shape.field("size", array_of<3>(quantity("m", Range::above(0))), "lengths of the edges of a box along x, y and z",
                  &O::Box::size),
      shape.field("file", text(),
                  "closed surface of triangles, relative to the input file; .stl, or the triangles of a .msh",
                  &O::Surface::file),
      shape.field("scale", quantity("1", Range::above(0)), "factor of the coordinates of a surface", &O::Surface::scale)
          .otherwise("1"),
      field("side", &O::side, choice_of<Side>({{"outside", Side::outside}, {"inside", Side::inside}}),
            "where the bodies are: around the obstacle, or within it as in a vessel")
          .otherwise("outside"),
  };
  for (const auto& key : drag_keys(of_contact)) keys.push_back(within(&O::drag, key));
  keys.push_back(field("motion", &O::motion, map_of(motion_keys()), "prescribed motion; functions of t")
                     .otherwise_in_words("none"));
  return {std::move(keys), {}, &O::where};
}

Section<ContactPairConfig> pair_keys() {
  using P = ContactPairConfig;
  std::vector<Field<P>> keys{
      field("name", &P::name, column_name(),
            "prefix of the columns in history.csv with the force and impulse of `with` on `surface`")
          .otherwise_in_words("no columns")
          .only_with({{"with"}}),
      field("surface", &P::part, name_of_part(), "a surface, a volume with its outer surface, a free shell or a rod")
          .required(),
      field("with", &P::with, name_of_part(), "what it may touch: as `surface`").otherwise_in_words("itself"),
      field("law", &P::law, normal_kind(), "as of `contact`").otherwise_in_words(of_contact),
      field("stiffness", &P::stiffness, quantity("Pa/m", Range::above(0)),
            "pressure per depth of penetration, or the scale of the barrier's pressure")
          .otherwise_in_words("that of `contact`, or the harmonic mean of both bodies' 30 shear moduli per "
                              "size of a facet"),
      field("width", &P::width, quantity("m", Range::above(0)),
            "distance at which the barrier begins, or half the distance over which the penalty's kink is rounded")
          .otherwise_in_words("that of `contact`, or 1/50 of the size of a facet, of a barrier at most half of the "
                              "distance at the start"),
      field("thickness", &P::thickness, quantity("m", Range::at_least(0)),
            "distance that the surfaces keep, such as that of a skin which the mesh does not have; that of free shells "
            "and axes of rods includes their own thickness")
          .otherwise_in_words(
              "the `threshold` of `contact`, and half of the thickness of each free shell or rod of the "
              "pair"),
  };
  for (const auto& key : drag_keys(of_contact)) keys.push_back(within(&P::drag, key));
  return {std::move(keys), {}, &P::where};
}

/// `[finger, ball]`, which names the two of a pair.
bool are_two_names(const InputNode& node) {
  return node.kind == InputNode::Kind::list && node.children.size() == 2 &&
         std::ranges::all_of(node.children, [](const InputNode& n) { return n.kind == InputNode::Kind::scalar; });
}

/// Reports pairs that are lists of names. Returns whether there are any.
bool refuse_names(const InputNode& pairs, const std::string& key, Diagnostics& diagnostics) {
  const auto refuse = [&](const InputNode& two) {
    diagnostics.add(two.where, "a pair of '" + key + "' is a map, here {surface: " + excerpt(two.children[0].text) +
                                   ", with: " + excerpt(two.children[1].text) + "}");
  };
  if (are_two_names(pairs)) {
    refuse(pairs);
    return true;
  }
  for (const InputNode& entry : pairs.children) {
    if (are_two_names(entry)) refuse(entry);
  }
  return std::ranges::any_of(pairs.children, are_two_names);
}

Format<ContactPairsConfig> pairs_of_bodies() {
  const auto word = choice({"all"});
  const auto list = list_of(map_of(pair_keys()), 1);
  Format<ContactPairsConfig> format{
      "`all`, or a " + list.type, either_schema(word.schema, list.schema), {}, {}, list.children, list.groups};
  format.read = [word, list](const InputNode& node, const std::string& key, Diagnostics& diagnostics,
                             ContactPairsConfig& into) {
    if (node.kind == InputNode::Kind::list) {
      return !refuse_names(node, key, diagnostics) && list.read(node, key, diagnostics, into.list);
    }
    if (node.kind == InputNode::Kind::scalar && node.text != "all") {
      return refuse(node, key, "'all' or a list such as [{surface: finger, with: ball}]", diagnostics);
    }
    std::string all;
    into.all = word.read(node, key, diagnostics, all);
    return into.all;
  };
  format.write = [word, list](const ContactPairsConfig& pairs) {
    return pairs.all ? word.write("all") : list.write(pairs.list);
  };
  return format;
}

}  // namespace

Section<ContactConfig> contact_keys() {
  using C = ContactConfig;
  std::vector<Field<C>> keys{
      within(&C::pressure, law_key()),
      selector<C>("surface", Selection::Kind::surface,
                  "the part of the bodies' surface that may touch obstacles, and with `pairs: all` each other")
          .otherwise_in_words("all of it"),
      selector<C>("box", Selection::Kind::box, "instead of `surface`: boundary facets inside this box"),
      selector<C>("where", Selection::Kind::where, "instead of `surface`: boundary facets that satisfy this condition"),
  };
  for (const auto& key : pressure_keys()) keys.push_back(within(&C::pressure, key));
  for (const auto& key : drag_keys("0")) keys.push_back(within(&C::drag, key));
  keys.push_back(
      field(
          "friction_update", &C::friction_update,
          choice_of<FrictionUpdate>({{"frozen", FrictionUpdate::frozen}, {"iterated", FrictionUpdate::iterated}}),
          "state that gives friction and damping their pressure and normal: the solution of a stage, found by solving "
          "again until they no longer change, or the start of the step, which is of first order in time and misses "
          "impacts that last a few steps")
          .otherwise("iterated"));
  keys.push_back(field("stick_velocity", &C::stick_velocity, quantity("m/s", Range::above(0)),
                       "below this velocity a contact counts as sticking: friction grows smoothly up to it")
                     .otherwise("1 mm/s"));
  keys.push_back(field("pairs", &C::pairs, pairs_of_bodies(),
                       "parts of the bodies that may touch one another; `all`: the outer surfaces of all bodies, "
                       "free shells and rods, with each other and with themselves")
                     .otherwise_in_words("bodies pass through one another"));
  keys.push_back(
      field("exclude", &C::exclude, list_of(array_of<2>(name_of_part()), 1),
            "two surfaces or volumes each that do not touch although `pairs` says so, such as the sides of a hinge")
          .otherwise_in_words("none")
          .only_with({{"pairs"}}));
  keys.push_back(
      field("start", &C::start,
            choice_of<ContactStart>({{"as-meshed", ContactStart::as_meshed}, {"resolve", ContactStart::resolve}}),
            "what to do about bodies that touch at the start, or overlap by less than the size of a facet: an error, "
            "or move their surfaces apart in the mesh, without strain")
          .otherwise("as-meshed"));
  keys.push_back(field("obstacles", &C::obstacles, list_of(map_of(obstacle_keys()), 1),
                       "rigid obstacles that the bodies can touch")
                     .otherwise_in_words("none"));
  using Need = KeyGroup::Need;
  return {std::move(keys),
          {{{"surface", "box", "where"}, Need::at_most_one}, {{"pairs", "obstacles"}, Need::at_least_one}},
          &C::where};
}

}  // namespace pliant
