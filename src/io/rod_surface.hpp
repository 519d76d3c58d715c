/// What is seen of rods: prisms around their axes.
#pragma once

#include "io/body_surface.hpp"
#include "io/result_writer.hpp"

namespace pliant {

/// Adds a prism with the section of the rod around each segment, whose vertices move with the four nodes of the
/// segment: the last of BodySurface::blends.
void add_prisms(const OutputMesh& mesh, BodySurface& surface);

}  // namespace pliant
