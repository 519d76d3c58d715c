/// The unit sphere as triangles.
#pragma once

#include "base/vector3.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace pliant {

struct Sphere {
  std::vector<Vector3<double>> points;
  std::vector<std::array<std::int32_t, 3>> triangles;  ///< anticlockwise seen from outside
};

/// An octahedron whose triangles are divided into four, `divisions` times. Four triangles in a row are one of those
/// before; the first three have a corner of it first, the fourth is in its middle.
Sphere unit_sphere(int divisions);

}  // namespace pliant
