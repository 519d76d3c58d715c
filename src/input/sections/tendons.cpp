#include "input/sections/tendons.hpp"

#include "input/formats.hpp"
#include "input/sections/body_point.hpp"

namespace pliant {
Section<TendonConfig> tendon_keys() {
  using T = TendonConfig;
  using Need = KeyGroup::Need;
  return {
      {
          field("name", &T::name, column_name(), "prefix of its columns in history.csv").required(),
          field("points", &T::points, list_of(body_point(), 2),
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
