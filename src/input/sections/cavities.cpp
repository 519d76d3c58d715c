#include "input/sections/cavities.hpp"

#include "input/alternatives.hpp"

namespace pliant {
namespace {

using SelectionKind = Selection::Kind;
using GasKeys = CavityConfig::Gas;
using LiquidKeys = CavityConfig::Liquid;

Section<GasKeys> gas_keys() {
  return {{
      field("pressure", &GasKeys::pressure, quantity("Pa"), "pressure at the start, above the ambient one")
          .otherwise("0"),
      field("ambient", &GasKeys::ambient, quantity("Pa", Range::at_least(0)), "absolute pressure of the surroundings")
          .otherwise("101325"),
      field("exponent", &GasKeys::exponent, quantity("1", Range::above(0)),
            "n of (absolute pressure) * volume^n = constant: 1 isothermal, 1.4 adiabatic air")
          .otherwise("1"),
      field("amount", &GasKeys::amount, expression("1", Variables::time),
            "amount of gas relative to that at the start, such as 1 + 2*t where gas is pumped in")
          .otherwise("1"),
  }};
}

Section<LiquidKeys> liquid_keys() {
  return {{
      field("bulk_modulus", &LiquidKeys::bulk_modulus, quantity("Pa", Range::above(0)),
            "pressure per relative change of volume")
          .otherwise("2.2e9"),
      field("pressure", &LiquidKeys::pressure, quantity("Pa"), "pressure at the start").otherwise("0"),
      field("added_volume", &LiquidKeys::added_volume, expression("m^3", Variables::time),
            "liquid pumped in since the start")
          .otherwise("0"),
      field("flow", &LiquidKeys::flow, expression("m^3/s", Variables::time),
            "liquid pumped in per time, in addition to added_volume")
          .otherwise("0"),
  }};
}

}  // namespace

Section<CavityConfig> cavity_keys() {
  using C = CavityConfig;
  return {{
              field("name", &C::name, column_name(), "prefix of the cavity's columns in history.csv").required(),
              selector<C>("surface", SelectionKind::surface, "the walls of the cavity, a part of the outer surface"),
              selector<C>("box", SelectionKind::box, "instead of `surface`: boundary facets inside this box"),
              selector<C>("where", SelectionKind::where,
                          "instead of `surface`: boundary facets that satisfy this condition"),
              choosing_field(&C::content, "pressure", expression("Pa", Variables::time), "a prescribed pressure",
                             &C::GivenPressure::value),
              choosing_field(&C::content, "gas", map_of(gas_keys()), "a gas; `{}` takes the defaults"),
              choosing_field(&C::content, "liquid", map_of(liquid_keys()), "a liquid; `{}` takes the defaults"),
              field("volume", &C::volume, quantity("m^3", Range::above(0)),
                    "volume of the cavity in the reference configuration")
                  .otherwise_in_words("the volume that the walls enclose, with flat lids on open ends"),
          },
          {{{"surface", "box", "where"}}, {{"pressure", "gas", "liquid"}}},
          &C::where};
}

}  // namespace pliant
