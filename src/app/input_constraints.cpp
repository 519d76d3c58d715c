#include "app/input_constraints.hpp"

namespace pliant {

Section<ConstraintConfig> constraint_keys() {
  using Kind = Selection::Kind;
  return {{
              selector<ConstraintConfig>("surface", Kind::surface, "nodes of this surface"),
              selector<ConstraintConfig>("volume", Kind::volume, "nodes of this volume"),
              selector<ConstraintConfig>("curve", Kind::curve, "nodes of this curve"),
              selector<ConstraintConfig>("point", Kind::point, "nodes of this point group"),
              selector<ConstraintConfig>("box", Kind::box, "nodes inside this box"),
              selector<ConstraintConfig>("where", Kind::where, "nodes whose reference position fulfils this"),
              field("displacement", &ConstraintConfig::displacement,
                    array_of<3>(expression_or_free("m", Variables::space_and_time)),
                    "prescribed displacement; a component `free` is left alone")
                  .required(),
          },
          {{{"surface", "volume", "curve", "point", "box", "where"}}},
          &ConstraintConfig::where};
}

}  // namespace pliant
