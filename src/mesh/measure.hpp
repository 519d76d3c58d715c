/// Size and quality of the distributed mesh.
#pragma once

#include "mesh/mesh.hpp"

namespace pliant {

/// Fills the counts, bounds, volume and quality of `mesh.report` from the distributed cells, and broadcasts what rank 0
/// knows about the file. `source`: which cells stand for what else. Collective.
void measure(MPI_Comm comm, const MeshSource& source, Mesh& mesh);

}  // namespace pliant
