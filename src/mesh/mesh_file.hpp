/// Pliant's own mesh format: an HDF5 file from which every rank can read its part, so that no rank holds the whole of a
/// large mesh.
///
///   /                 attributes: format "pliant-mesh", version 1
///   /nodes            (nodes, 3): positions; every node is a corner of a tetrahedron
///   /cells            (cells, 4): nodes from 0, positively oriented
///   /groups/0 ...     a dataset per physical group, attributes: dimension, tag, name. Volumes: (members), cells from
/// 0.
///                     Others: (members, 2), a cell and the index of its facet (i is opposite to corner i), edge (as in
///                     `local_edges`) or corner. Each member once, by ascending cells.
///   /cell_data/0 ...  a dataset per field of numbers of cells, (cells, components); attribute: name
///
/// Such a file is made from a mesh that was repaired and checked as a whole (repair.hpp, dual_graph.hpp), which no rank
/// could do with its part. First-order geometry only.
#pragma once

#include "mesh/distribute.hpp"

#include <cstdint>
#include <string>

namespace pliant {

inline constexpr const char* mesh_file_format = "pliant-mesh";
inline constexpr std::int64_t mesh_file_version = 1;

/// Whether the name is that of such a file (.h5, .hdf5).
bool is_mesh_file(const std::string& file);

/// Reads this rank's block of the cells, with its part of the groups and data, and its block of the nodes; of a mesh
/// that one rank can hold, rank 0 reads all (PETSc option -mesh_cells_on_root), and has still to partition it. Throws
/// InputError at `source.where` for a file that is not of this format, of another version or incomplete, for nodes that
/// are not finite, and for impossible cells or members of groups; the same on every rank. Collective.
MeshParts read_mesh_file(MPI_Comm comm, const MeshSource& source);

}  // namespace pliant
