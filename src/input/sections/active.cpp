#include "input/sections/active.hpp"

#include "input/alternatives.hpp"
#include "input/sections/cell_data.hpp"

namespace pliant {

Section<ActiveConfig> active_keys() {
  using A = ActiveConfig;
  return {
      {
          direction_field("fibre", &A::fibre, "direction of the contraction")
              .otherwise_in_words("the fibre of the elastic law"),
          choosing_field(&A::contraction, "stress", expression("Pa", Variables::space_and_time),
                         "active stress: tension along the fibres per reference area, in addition to the elastic law",
                         &A::Stress::tension),
          choosing_field(
              &A::contraction, "shortening", expression("1", Variables::space_and_time),
              "active strain: fraction of their length by which the fibres shorten, below 1; the elastic law "
              "sees the rest of the deformation",
              &A::Shortening::part),
      },
      {{{"stress", "shortening"}, KeyGroup::Need::exactly_one}},
      &A::where};
}

Section<ExpansionConfig> expansion_keys() {
  using E = ExpansionConfig;
  return {{
              field("stretch", &E::stretch, expression("1", Variables::space_and_time),
                    "length of a free body over its length in the mesh, > 0; 1: no expansion"),
          },
          {},
          &E::where};
}

}  // namespace pliant
