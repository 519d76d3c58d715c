/// Where the mesh of an input comes from.
#pragma once

#include "input/config.hpp"
#include "mesh/mesh.hpp"

namespace pliant {

/// The file, and what is added to it for bodies without a mesh.
MeshSource mesh_source(const Config& config);

}  // namespace pliant
