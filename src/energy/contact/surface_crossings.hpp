/// Where surfaces of bodies pass through each other.
#pragma once

#include "energy/contact/body_surfaces.hpp"

#include <span>

namespace pliant {

/// Edges that pass through triangles, where bodies overlap.
struct SurfaceCrossings {
  int count = 0;
  Vector3<double> place{};  ///< of one of them [m]
  int body = 0, other = 0;  ///< whose surfaces cross there
};

/// Those of triangles that are near one another, in exact arithmetic; `x`: positions of the vertices [m]. Rank-local.
SurfaceCrossings find_crossings(const BodySurfaces& surfaces, const NearPatches& near,
                                std::span<const Vector3<double>> x);

}  // namespace pliant
