/// What reads the files of users and of other programs, fed with any bytes. Each either takes them or throws the
/// failure that tells the user; anything else (a crash, another exception, a broken promise) is a fault of ours.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace pliant::fuzz {

struct Target {
  const char* name;  ///< of the folder with its corpus, too
  void (*run)(std::string_view bytes);
  int rounds = 400;  ///< of random damage in the ordinary tests
};

/// The input file; one that is taken is written as `run.yaml` and must read back as the same.
void read_as_input(std::string_view bytes);
/// The file of a fit, of a material or of an input.
void read_as_fit(std::string_view bytes);
/// A gmsh mesh with all that follows until it lies in PETSc.
void read_as_msh(std::string_view bytes);
/// Likewise meshes of other programs.
void read_as_abaqus(std::string_view bytes);
void read_as_nastran(std::string_view bytes);
void read_as_medit(std::string_view bytes);
void read_as_unv(std::string_view bytes);
void read_as_vtk(std::string_view bytes);
void read_as_vtu(std::string_view bytes);
void read_as_med(std::string_view bytes);
/// A mesh in Pliant's own format.
void read_as_mesh_file(std::string_view bytes);
/// A surface of triangles (.stl), which gmsh reads in a process of its own: what comes back from there.
void read_as_surface(std::string_view bytes);
/// The corners that come back, as a binary STL file has them: the surface and its distance, without gmsh.
void read_as_triangles(std::string_view bytes);
/// The frames of a run: told of, and taken up by a run that goes on.
void read_as_result(std::string_view bytes);
/// A checkpoint. Its checksum would stop every damage at the door, so it is made right before.
void read_as_checkpoint(std::string_view bytes);

}  // namespace pliant::fuzz
