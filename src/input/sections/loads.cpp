#include "input/sections/loads.hpp"

namespace pliant {
namespace {

using SelectionKind = Selection::Kind;

/// The value of a load, which decides the load's kind.
Field<LoadConfig> load(LoadConfig::Kind kind, Field<LoadConfig> result) {
  result.read = [kind, read = result.read](const InputNode& node, Diagnostics& diagnostics, LoadConfig& into) {
    into.kind = kind;
    read(node, diagnostics, into);
  };
  return std::move(result).left_out_if([kind](const LoadConfig& l) { return l.kind != kind; });
}

}  // namespace

Section<LoadConfig> load_keys() {
  using L = LoadConfig;
  using Need = KeyGroup::Need;
  const auto vector = [](const std::string& unit) { return array_of<3>(expression(unit, Variables::space_and_time)); };
  const auto coefficient_of = [](const std::string& unit) { return quantity(unit, Range::at_least(0)); };
  const std::vector<Anchor> foundation{{"spring"}, {"dashpot"}}, point_foundation{{"point_spring"}, {"point_dashpot"}};
  return {
      {
          load(L::Kind::gravity, field("gravity", &L::value, vector("m/s^2"), "acceleration of gravity, acts on mass")),
          load(L::Kind::force_density,
               field("force_density", &L::value, vector("N/m^3"), "force per reference volume")),
          selector<L>("volume", SelectionKind::volume, "with gravity and force_density: the volume it acts on")
              .otherwise_in_words("the whole mesh"),
          load(L::Kind::traction,
               field("traction", &L::value, vector("Pa"), "force per reference area, fixed in direction (dead)")),
          load(L::Kind::pressure,
               field("pressure", &L::pressure, expression("Pa", Variables::space_and_time),
                     "force per current area, against the outward normal: it follows the surface, and pushes where it "
                     "is positive")),
          load(L::Kind::line_force,
               field("line_force", &L::value, vector("N/m"), "force per reference length of a curve")),
          load(
              L::Kind::force,
              field("force", &L::value, vector("N"),
                    "total force, fixed in direction: spread evenly over the reference area of a surface or the length "
                    "of a curve, or shared by the nodes of a point group")),
          load(L::Kind::foundation,
               field("spring", &L::spring, coefficient_of("Pa/m"),
                     "stiffness per reference area of springs between the surface and the ground")),
          load(L::Kind::foundation,
               field("dashpot", &L::dashpot, coefficient_of("Pa*s/m"),
                     "viscosity per reference area of dashpots between the surface and the ground")),
          field("direction", &L::direction,
                choice_of<FoundationDirection>(
                    {{"all", FoundationDirection::all}, {"normal", FoundationDirection::normal}}),
                "with spring and dashpot: whether they resist every displacement, or the part along the reference "
                "normal alone")
              .otherwise("all")
              .left_out_if([](const L& l) { return l.kind != L::Kind::foundation; }),
          load(
              L::Kind::point_foundation,
              field(
                  "point_spring", &L::spring, coefficient_of("N/m"),
                  "stiffness of springs between a point group and the ground, in all directions; shared by its nodes")),
          load(L::Kind::point_foundation,
               field("point_dashpot", &L::dashpot, coefficient_of("N*s/m"), "the same of dashpots")),
          selector<L>("surface", SelectionKind::surface,
                      "with traction, pressure, force, spring and dashpot: the surface it acts on"),
          selector<L>("box", SelectionKind::box, "the same: boundary facets inside this box"),
          selector<L>("where", SelectionKind::where, "the same: boundary facets that fulfil this"),
          selector<L>("curve", SelectionKind::curve, "with line_force and force: the curve it acts on"),
          selector<L>("point", SelectionKind::point,
                      "with force, point_spring and point_dashpot: the point group it acts on"),
      },
      {{{"gravity", "traction", "pressure", "force_density", "line_force", "force", "spring", "dashpot", "point_spring",
         "point_dashpot"},
        Need::exactly_one,
        {},
        {{"spring", "dashpot"}, {"point_spring", "point_dashpot"}}},
       {{"volume"}, Need::any, {{"gravity"}, {"force_density"}}},
       {{"surface", "box", "where"}, Need::exactly_one, {{"traction"}, {"pressure"}, {"spring"}, {"dashpot"}}},
       {{"surface", "box", "where", "curve", "point"}, Need::exactly_one, {{"force"}}},
       {{"curve"}, Need::all, {{"line_force"}}},
       {{"point"}, Need::all, point_foundation},
       {{"direction"}, Need::any, foundation}},
      &L::where};
}

}  // namespace pliant
