/// Parts of the mesh, as entries of the input name them.
#pragma once

#include "base/error.hpp"
#include "base/expression.hpp"

#include <array>
#include <optional>
#include <string>

namespace pliant {

/// The part of the mesh that an entry refers to. Exactly one way of selecting it is given.
struct Selection {
  enum class Kind { everything, volume, surface, curve, point, box, where };
  Kind kind = Kind::everything;
  std::string name;                  ///< physical name, or the tag in decimal digits (volume, surface, curve, point)
  std::array<double, 6> box{};       ///< xmin ymin zmin xmax ymax zmax [m] (box)
  std::optional<Expression> region;  ///< nonzero inside (where); a function of x, y, z
  Location where;
};

}  // namespace pliant
