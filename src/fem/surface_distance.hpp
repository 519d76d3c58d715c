/// The distance to a closed surface of triangles.
#pragma once

#include "fem/signed_distance.hpp"
#include "mesh/surface_file.hpp"

#include <memory>

namespace pliant {

/// Exact; the nearest triangle is found in a tree of boxes. Where the nearest point lies on a corner or an edge the
/// mean of the normals around it, weighted by their angles, distinguishes the sides (Baerentzen & Aanaes 2005, Signed
/// distance computation using the angle weighted pseudonormal). Across a face the distance is flat; around edges and
/// corners it is that of a cylinder or a sphere.
std::unique_ptr<SignedDistance> make_distance(const SurfaceMesh& surface);

}  // namespace pliant
