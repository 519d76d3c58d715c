/// Pressures at the vertices of a surface, from the forces on them.
#pragma once

#include "base/vector3.hpp"
#include "collision/surface.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace pliant {

/// The force on each vertex over the area that faces it [Pa]: of its triangles, as they lie at the positions `x` [m];
/// of shells either side, of rods the area of their segments. `triangles`: the numbers of those that count; the
/// vertices of others have no meaning. `slopes`: of the potential at the vertices, opposite to the forces [N].
std::vector<double> vertex_pressures(const CollisionSurface& surface, std::span<const std::int32_t> triangles,
                                     std::span<const Vector3<double>> x, std::span<const Vector3<double>> slopes);

}  // namespace pliant
