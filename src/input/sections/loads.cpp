#include "input/sections/loads.hpp"

#include "input/alternatives.hpp"

namespace pliant {
namespace {

using SelectionKind = Selection::Kind;

constexpr auto load_kind = &LoadConfig::kind;

}  // namespace

Section<LoadConfig> load_keys() {
  using L = LoadConfig;
  using Need = KeyGroup::Need;
  const auto vector = [](const std::string& unit) { return array_of<3>(expression(unit, Variables::space_and_time)); };
  const auto coefficient_of = [](const std::string& unit) { return quantity(unit, Range::at_least(0)); };
  return {
      {
          choosing_field(load_kind, "gravity", vector("m/s^2"), "acceleration of gravity, acts on mass",
                         &L::Gravity::acceleration),
          choosing_field(load_kind, "force_density", vector("N/m^3"), "force per reference volume",
                         &L::ForceDensity::value),
          selector<L>("volume", SelectionKind::volume,
                      "with gravity and force_density: the volume it acts on; with force and torque: a rigid body")
              .otherwise_in_words("the whole mesh"),
          choosing_field(load_kind, "traction", vector("Pa"), "force per reference area, fixed in direction (dead)",
                         &L::Traction::value),
          choosing_field(load_kind, "pressure", expression("Pa", Variables::space_and_time),
                         "force per current area, against the outward normal: it follows the surface, and pushes where "
                         "it is positive",
                         &L::Pressure::value),
          choosing_field(load_kind, "line_force", vector("N/m"), "force per reference length of a curve",
                         &L::LineForce::value),
          choosing_field(load_kind, "force", vector("N"),
                         "total force, fixed in direction: spread evenly over the reference area of a surface or the "
                         "length of a curve, shared by the nodes of a point group, or at the center of mass of a rigid "
                         "body",
                         &L::Force::value),
          choosing_field(load_kind, "torque", array_of<3>(expression("N*m", Variables::time)),
                         "torque on a rigid body, fixed in direction", &L::Torque::value),
          choosing_field(load_kind, "spring", coefficient_of("Pa/m"),
                         "stiffness per reference area of springs between the surface and the ground",
                         &L::Foundation::spring),
          choosing_field(load_kind, "dashpot", coefficient_of("Pa*s/m"),
                         "viscosity per reference area of dashpots between the surface and the ground",
                         &L::Foundation::dashpot),
          field_of(load_kind, "direction",
                   choice_of<FoundationDirection>(
                       {{"all", FoundationDirection::all}, {"normal", FoundationDirection::normal}}),
                   "with spring and dashpot: whether they resist every displacement, or only its component along the "
                   "reference normal",
                   &L::Foundation::direction)
              .otherwise("all")
              .only_with({{"spring"}, {"dashpot"}}),
          choosing_field(load_kind, "point_spring", coefficient_of("N/m"),
                         "stiffness of springs between a point group and the ground, in all directions; shared by its "
                         "nodes",
                         &L::PointFoundation::spring),
          choosing_field(load_kind, "point_dashpot", coefficient_of("N*s/m"),
                         "viscosity of dashpots between a point group and the ground; shared by its nodes",
                         &L::PointFoundation::dashpot),
          selector<L>("surface", SelectionKind::surface,
                      "with traction, pressure, force, spring and dashpot: the surface it acts on"),
          selector<L>("box", SelectionKind::box, "instead of `surface`: boundary facets inside this box"),
          selector<L>("where", SelectionKind::where,
                      "instead of `surface`: boundary facets that satisfy this condition"),
          selector<L>("curve", SelectionKind::curve, "with line_force and force: the curve it acts on"),
          selector<L>("point", SelectionKind::point,
                      "with force, point_spring and point_dashpot: the point group it acts on"),
      },
      {{{"gravity", "traction", "pressure", "force_density", "line_force", "force", "torque", "spring", "dashpot",
         "point_spring", "point_dashpot"},
        Need::exactly_one,
        {},
        {{"spring", "dashpot"}, {"point_spring", "point_dashpot"}}},
       {{"volume"}, Need::any, {{"gravity"}, {"force_density"}}},
       {{"surface", "box", "where"}, Need::exactly_one, {{"traction"}, {"pressure"}, {"spring"}, {"dashpot"}}},
       {{"surface", "box", "where", "curve", "point", "volume"}, Need::exactly_one, {{"force"}}},
       {{"volume"}, Need::all, {{"torque"}}},
       {{"curve"}, Need::all, {{"line_force"}}},
       {{"point"}, Need::all, {{"point_spring"}, {"point_dashpot"}}}},
      &L::where};
}

}  // namespace pliant
