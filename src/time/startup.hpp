/// How multistep methods obtain their first states.
#pragma once

namespace pliant {

enum class Startup {
  ramp,   ///< by formulas with fewer states, backward Euler first: robust, but costs third-order methods one order. Not
          ///< for steps that follow a tight tolerance: backward Euler then needs steps of the size of the tolerance, so
          ///< short that the rounding of v = (q - q0) / dt may exceed their allowed error
  dirk33  ///< by steps of dirk33, which keeps the order of all methods of the table
};

}  // namespace pliant
