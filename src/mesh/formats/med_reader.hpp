/// Reads meshes of Salome and Code_Aster.
#pragma once

#include "mesh/serial_mesh.hpp"

#include <string>

namespace pliant {

/// Reads a MED file (.med, an HDF5 file of MED 2.3 to 4): the groups of elements are volumes of their tetrahedra,
/// surfaces of their triangles and curves of their lines, those of nodes are points. Tetrahedra are reoriented, because
/// MED's orientation is opposite to Pliant's. HDF5 crashes on some damaged files: to be called in an `isolated`
/// process. Source: MED 4.0 documentation, "Format interne". Throws MeshDefect; FileError if the file cannot be read.
/// Not collective.
SerialMesh read_med(const std::string& file);

}  // namespace pliant
