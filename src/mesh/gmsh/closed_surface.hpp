/// Converts the triangles of an STL file to volumes that gmsh can mesh.
#pragma once

namespace pliant {

/// Whether the triangles of the file bound the mesh as they are, or are replaced by new ones of the target size.
enum class Triangles { keep, remesh };

/// Takes the triangles of gmsh's current model as closed shells and adds the volumes that they enclose; a shell within
/// a volume is a cavity, a shell within a cavity a body again. Throws MeshDefect if the surface is not closed.
void add_enclosed_volumes(Triangles triangles);

}  // namespace pliant
