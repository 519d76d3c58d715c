#include "app/input_loads.hpp"

namespace pliant {
namespace {

using Kind = Selection::Kind;

/// The value of a load, which decides the load's kind.
Field<LoadConfig> load(LoadConfig::Kind kind, Field<LoadConfig> result) {
  result.read = [kind, read = result.read](const InputNode& node, Problems& problems, LoadConfig& into) {
    into.kind = kind;
    read(node, problems, into);
  };
  return std::move(result).left_out_if([kind](const LoadConfig& l) { return l.kind != kind; });
}

}  // namespace

Section<LoadConfig> load_keys() {
  const auto vector = [](const std::string& unit) { return array_of<3>(expression(unit, Variables::space_and_time)); };
  return {
      {
          load(LoadConfig::Kind::gravity,
               field("gravity", &LoadConfig::value, vector("m/s^2"), "acceleration of gravity, acts on mass")),
          selector<LoadConfig>("volume", Kind::volume, "with gravity: the volume it acts on")
              .otherwise_in_words("the whole mesh"),
          load(LoadConfig::Kind::traction, field("traction", &LoadConfig::value, vector("Pa"),
                                                 "force per reference area, fixed in direction (dead)")),
          load(LoadConfig::Kind::pressure,
               field("pressure", &LoadConfig::pressure, expression("Pa", Variables::space_and_time),
                     "force per current area, against the outward normal: it follows the surface, and pushes where it "
                     "is positive")),
          selector<LoadConfig>("surface", Kind::surface, "with traction and pressure: the surface it acts on"),
          selector<LoadConfig>("box", Kind::box, "with traction and pressure: boundary facets inside this box"),
          selector<LoadConfig>("where", Kind::where, "with traction and pressure: boundary facets that fulfil this"),
      },
      {{{"gravity", "traction", "pressure"}},
       {{"volume"}, KeyGroup::Need::any, {{"gravity"}}},
       {{"surface", "box", "where"}, KeyGroup::Need::exactly_one, {{"traction"}, {"pressure"}}}},
      &LoadConfig::where};
}

}  // namespace pliant
