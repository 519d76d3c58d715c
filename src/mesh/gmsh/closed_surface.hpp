/// From the triangles of an STL file to volumes that gmsh can mesh.
#pragma once

namespace pliant {

/// Whether the triangles of the file bound the mesh as they are, or give way to new ones of the wanted size.
enum class Triangles { keep, remesh };

/// Takes the triangles in gmsh's current model as closed shells and adds the volumes they bound; shells inside of a
/// volume are its cavities, shells inside of a cavity bodies again. Throws MeshDefect if the surface is not closed.
void add_enclosed_volumes(Triangles triangles);

}  // namespace pliant
