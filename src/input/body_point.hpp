/// Places that are fixed in bodies: ends of springs.
#pragma once

#include "base/error.hpp"

#include <array>
#include <string>

namespace pliant {

/// A place at the start: in whatever cell of the mesh holds it, in a rigid body, or in space.
struct BodyPoint {
  std::string body;               ///< a rigid body or `ground`; empty: in the mesh
  std::array<double, 3> point{};  ///< [m]
  Location where;
};

}  // namespace pliant
