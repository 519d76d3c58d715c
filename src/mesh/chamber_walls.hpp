/// Which way the walls of a chamber face, where free shells, which have two sides, are among them.
#pragma once

#include "base/orientation.hpp"
#include "base/vector3.hpp"

#include <array>
#include <functional>
#include <span>
#include <vector>

#include <petscsys.h>

namespace pliant {

using WallTriangle = std::array<PetscInt, 3>;  ///< nodes
using PlaceOfNode = std::function<Vector3<double>(PetscInt)>;

/// The volume behind some of the triangles: positive if their normals point out of what they enclose [m^3].
double volume_behind(std::span<const WallTriangle> triangles, std::span<const std::size_t> part,
                     const PlaceOfNode& place);

/// Swaps corners of the triangles of a surface such that normals point into its chamber. Those of bodies, whose normals
/// point out of the material, stay, and their neighbours follow them. Where there are none of a body, normals point
/// into what the triangles enclose, and out of it where this lies within another part of the surface. Returns which
/// triangles have their orientation from one of these rules; the others stay.
std::vector<char> orient_walls(std::vector<WallTriangle>& triangles, std::span<const char> is_of_body,
                               const PlaceOfNode& place);

}  // namespace pliant
