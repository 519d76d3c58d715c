#include "input/sections/rods.hpp"

#include "input/formats.hpp"

namespace pliant {
namespace {

Section<Rectangle> rectangle_keys() {
  using R = Rectangle;
  return {{
      field("width", &R::width, quantity("m", Range::above(0)), "side across `up`").required(),
      field("height", &R::height, quantity("m", Range::above(0)), "side along `up`").required(),
      field("up", &R::up, direction_of_any_length(), "direction of the height at the start, all along the rod")
          .required(),
      field("torsion_constant", &R::torsion, quantity("m^4", Range::above(0)),
            "torsional stiffness divided by the shear modulus")
          .otherwise_in_words("that of the rectangle, by Saint-Venant"),
  }};
}

/// `circle`, or the sides of a rectangle.
Format<std::optional<Rectangle>> section() {
  const auto circle = choice({"circle"});
  const Format<Rectangle> rectangle = map_of(rectangle_keys());
  Format<std::optional<Rectangle>> format{"`circle`, with `radius`, or `{width: .., height: .., up: [..]}`",
                                          either_schema(circle.schema, rectangle.schema),
                                          {},
                                          {},
                                          rectangle.children,
                                          rectangle.groups};
  format.read = [circle, rectangle](const InputNode& node, const std::string& name, Diagnostics& diagnostics,
                                    std::optional<Rectangle>& into) {
    if (node.kind == InputNode::Kind::map) return rectangle.read(node, name, diagnostics, into.emplace());
    std::string word;
    return circle.read(node, name, diagnostics, word);
  };
  format.write = [rectangle](const std::optional<Rectangle>& from) {
    return from ? rectangle.write(*from) : InputNode::scalar("circle");
  };
  return format;
}

}  // namespace

Section<RodConfig> rod_keys() {
  using R = RodConfig;
  using Need = KeyGroup::Need;
  const std::string holder = " is fixed: a rigid body, or `ground`";
  return {
      {
          field("name", &R::name, column_name(), "name of the rod, and prefix of its columns in history.csv")
              .required(),
          field("points", &R::points, list_of(array_of<3>(quantity("m")), 2),
                "places of its axis at the start, in their order; it is straight between them, and without force")
              .left_out_if([](const R& rod) { return rod.points.empty(); }),
          field("curve", &R::curve, text(),
                "instead of `points`: a physical curve of the mesh, whose nodes are those of the rod")
              .left_out_if([](const R& rod) { return rod.curve.empty(); }),
          field("segments", &R::segments, integer(Range::at_least(1)),
                "number of segments between two neighbouring points")
              .otherwise_in_words("1")
              .only_with({{"points"}}),
          field("size", &R::size, quantity("m", Range::above(0)), "instead of `segments`: greatest length of a segment")
              .otherwise_in_words("none")
              .only_with({{"points"}}),
          field("radius", &R::radius, quantity("m", Range::above(0)), "radius of a round section")
              .otherwise_in_words("none; a round section needs one"),
          field("section", &R::section, section(), "shape of the section").otherwise("circle"),
          field("density", &R::density, quantity("kg/m^3", Range::at_least(0)), "mass density").otherwise("0"),
          field("youngs_modulus", &R::youngs_modulus, quantity("Pa", Range::above(0)), "Young's modulus").required(),
          field("poissons_ratio", &R::poissons_ratio, quantity("1", {-1.0, 0.5, Range::Ends::high_included}),
                "Poisson's ratio")
              .required(),
          field(
              "damping", &R::damping, quantity("s", Range::at_least(0)),
              "viscosity: resistance to rates of stretch, bending and twist, as this time multiplied by the stiffness")
              .otherwise("0"),
          field("bending", &R::bends, truth(),
                "whether it resists bending and twist, besides stretch; without, it follows a `curve` in bodies")
              .otherwise_in_words("true, unless the cells of the body around it resist a hundred times as much"),
          field("start", &R::start, text(), "in what its section at the first point" + holder)
              .otherwise_in_words("in nothing: it is free")
              .left_out_if([](const R& rod) { return rod.start.value.empty(); }),
          field("end", &R::end, text(), "in what its section at the last point" + holder)
              .otherwise_in_words("in nothing: it is free")
              .left_out_if([](const R& rod) { return rod.end.value.empty(); }),
      },
      {{{"points", "curve"}, Need::exactly_one}, {{"segments", "size"}, Need::at_most_one}},
      &R::where};
}

}  // namespace pliant
