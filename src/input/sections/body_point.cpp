#include "input/sections/body_point.hpp"

#include "input/formats.hpp"

namespace pliant {

Format<BodyPoint> body_point() {
  using B = BodyPoint;
  const auto place = array_of<3>(quantity("m"));
  const Format<BodyPoint> of_body = map_of(Section<BodyPoint>{{
      field("body", &B::body, text(), "name of a rigid body, or `ground`").required(),
      field("point", &B::point, place, "place at the start").required(),
  }});
  Format<BodyPoint> format{
      "place in the mesh `[x, y, z]` [m], or `{body: name, point: [x, y, z]}` in a rigid body or "
      "on the `ground`",
      either_schema(place.schema, of_body.schema),
      {},
      {}};
  format.read = [place, of_body](const InputNode& node, const std::string& name, Diagnostics& diagnostics,
                                 BodyPoint& into) {
    into.where = node.where;
    if (node.kind == InputNode::Kind::map) return of_body.read(node, name, diagnostics, into);
    if (node.kind == InputNode::Kind::list) return place.read(node, name, diagnostics, into.point);
    return refuse(node, name, "a place [x, y, z], or {body: name, point: [x, y, z]}", diagnostics);
  };
  format.write = [place, of_body](const BodyPoint& from) {
    return from.body.empty() ? place.write(from.point) : of_body.write(from);
  };
  return format;
}

}  // namespace pliant
