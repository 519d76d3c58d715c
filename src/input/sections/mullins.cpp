#include "input/sections/mullins.hpp"

#include "input/alternatives.hpp"

namespace pliant {

Section<MullinsConfig> mullins_keys() {
  using M = MullinsConfig;
  const auto constant = [](const auto& field) { return within(&M::law, field); };
  return {
      {
          constant(field("r", &Mullins::r, quantity("1", Range::above(1)),
                         "limit of softening: the stress falls to no less than 1 - 1/r of the law's")
                       .required()),
          constant(field("m", &Mullins::m, quantity("Pa", Range::at_least(0)),
                         "energy per volume (1 Pa = 1 J/m^3) over which softening sets in after a reversal, whatever "
                         "the largest strain; `m` or `beta` must be above 0")
                       .otherwise("0")),
          constant(field("beta", &Mullins::beta, quantity("1", Range::at_least(0)),
                         "the same as a fraction of the largest energy of the past")
                       .otherwise("0")),
      },
      {},
      &M::where};
}

}  // namespace pliant
