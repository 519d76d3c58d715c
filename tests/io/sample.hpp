// A small mesh and fields to write, the same on any number of ranks, and a directory to write to.
#pragma once

#include "io/result_writer.hpp"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <mpi.h>

namespace pliant {

enum class Split { even, none_on_last_rank };

/// A block of 3 x 2 x 2 cubes of 6 tetrahedra each, of side 0.5 m; two bodies. Nodes and cells are dealt to the ranks
/// of `comm` in contiguous blocks.
OutputMesh sample_mesh(MPI_Comm comm, int nodes_per_cell, Split split = Split::even);

/// u = (0.1 t x y, 0, -t z^2) of the owned nodes [m].
std::vector<double> sample_displacement(const OutputMesh& mesh, double t);

/// (xx, yy, zz, xy, yz, xz) = (1, 2, 3, 4, 5, 6) t + body of the owned cells [Pa].
std::vector<double> sample_stress(const OutputMesh& mesh, double t);

/// Writes the frame of time t with the fields displacement (node), cauchy_stress (cell, 6) and density (cell, 1).
/// Collective.
void write_sample_frame(ResultWriter& writer, const OutputMesh& mesh, double t, std::int64_t step);

/// An empty directory of this test under the build tree, the same on every rank. Collective.
std::filesystem::path empty_directory(MPI_Comm comm, const std::string& name);

}  // namespace pliant
