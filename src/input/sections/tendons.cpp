#include "input/sections/tendons.hpp"

#include "input/formats.hpp"

namespace pliant {
namespace {

using Point = TendonConfig::Point;

Section<Point> point_keys() {
  return {{
      field("body", &Point::body, text(), "rigid body in which the point is fixed, also outside its mesh, or `ground`")
          .required(),
      field("point", &Point::place, array_of<3>(quantity("m")), "place of the point at the start").required(),
  }};
}

/// Three coordinates, or a map of `body` and `point`.
Format<Point> point() {
  const auto place = array_of<3>(quantity("m"));
  const auto fixed = map_of(point_keys());
  Format<Point> format{"list of 3 lengths [m], or `{body: name, point: [..]}`",
                       either_schema(place.schema, fixed.schema),
                       {},
                       {},
                       fixed.children,
                       fixed.groups};
  format.read = [place, fixed](const InputNode& node, const std::string& name, Diagnostics& diagnostics, Point& into) {
    into.where = node.where;
    return node.kind == InputNode::Kind::map ? fixed.read(node, name, diagnostics, into)
                                             : place.read(node, name, diagnostics, into.place);
  };
  format.write = [place, fixed](const Point& from) {
    return from.body.empty() ? place.write(from.place) : fixed.write(from);
  };
  return format;
}

}  // namespace

Section<TendonConfig> tendon_keys() {
  using T = TendonConfig;
  using Need = KeyGroup::Need;
  return {
      {
          field("name", &T::name, column_name(), "prefix of its columns in history.csv").required(),
          field("points", &T::points, list_of(point(), 2),
                "places in the bodies at the start through which it passes, in their order from the end where it is "
                "pulled; it is straight between them")
              .left_out_if([](const T& tendon) { return tendon.points.empty(); }),
          field("curve", &T::curve, text(), "instead of `points`: a physical curve of the mesh, whose nodes are points")
              .left_out_if([](const T& tendon) { return tendon.curve.empty(); }),
          field("pulled_at", &T::pulled_at, array_of<3>(quantity("m")),
                "place near the end of the curve where it is pulled")
              .otherwise_in_words("the beginning of the curve, as it is oriented in gmsh")
              .only_with({{"curve"}}),
          field("tension", &T::tension, expression("N", Variables::time), "force with which it is pulled"),
          field("pull", &T::pull, expression("m", Variables::time),
                "instead of `tension`: length by which its end is pulled out, through a spring of `stiffness`"),
          field("stiffness", &T::stiffness, quantity("N/m", Range::above(0)),
                "force per length of that spring, which stands for string and drive; it does not push")
              .only_with({{"pull"}}),
          field("friction", &T::friction, quantity("1", Range::at_least(0)),
                "coefficient of friction where it turns, from point to point")
              .otherwise("0"),
          field("stick_velocity", &T::stick_velocity, quantity("m/s", Range::above(0)),
                "below this velocity it counts as sticking: friction grows smoothly up to it")
              .otherwise("1 mm/s"),
      },
      {{{"points", "curve"}, Need::exactly_one}, {{"tension", "pull"}, Need::exactly_one}},
      &T::where};
}

}  // namespace pliant
