/// Reads meshes of Abaqus and CalculiX.
#pragma once

#include "mesh/serial_mesh.hpp"

#include <string>

namespace pliant {

/// Reads an input file (.inp): nodes, elements and sets, to the first *STEP; everything else is skipped.
///
/// * Element sets are volumes of their tetrahedra (C3D4, C3D10 and variants), surfaces of their triangles (S3, CPS3,
/// ...)
///   and curves of their lines (T3D2, B31, ...). Elements of other kinds than solids are left out with a notice.
/// * Surfaces of elements are surfaces.
/// * Node sets are points; those that have all corners of facets of the boundary are surfaces of these facets too,
/// unless
///   there is another surface of that name.
/// * Names are not case-sensitive. Sets and surfaces that are INTERNAL make no groups.
/// * One part or instance, without translation and rotation; a set of the assembly comes before one of the part with
/// the
///   same name, which then is "<part>.<name>".
/// Source: Abaqus Keywords Guide; CalculiX CrunchiX user's manual. Throws MeshDefect with the line of the error;
/// FileError if the file cannot be read. Not collective.
SerialMesh read_abaqus(const std::string& file);

}  // namespace pliant
