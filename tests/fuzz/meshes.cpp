#include "base/error.hpp"
#include "fuzz/files.hpp"
#include "fuzz/targets.hpp"
#include "mesh/gmsh_module.hpp"
#include "mesh/mesh.hpp"
#include "mesh/surface_file.hpp"

namespace pliant::fuzz {
namespace {

void read_as(std::string_view bytes, const char* extension) {
  const BytesInFile file(bytes, extension);
  MeshSource source;
  source.file = file.path().string();
  try {
    (void)read_mesh(MPI_COMM_SELF, source);
  } catch (const InputError&) {
  }
}

}  // namespace

void read_as_msh(std::string_view bytes) {
  read_as(bytes, ".msh");
}

void read_as_abaqus(std::string_view bytes) {
  read_as(bytes, ".inp");
}

void read_as_nastran(std::string_view bytes) {
  read_as(bytes, ".bdf");
}

void read_as_medit(std::string_view bytes) {
  read_as(bytes, ".mesh");
}

void read_as_unv(std::string_view bytes) {
  read_as(bytes, ".unv");
}

void read_as_vtk(std::string_view bytes) {
  read_as(bytes, ".vtk");
}

void read_as_vtu(std::string_view bytes) {
  read_as(bytes, ".vtu");
}

void read_as_med(std::string_view bytes) {
  read_as(bytes, ".med");
}

void read_as_surface(std::string_view bytes) {
  gmsh_module();  // loaded once, not by each child
  const BytesInFile file(bytes, ".stl");
  MeshSource source;
  source.file = file.path().string();
  try {
    (void)read_surface(MPI_COMM_SELF, source);
  } catch (const InputError&) {
  }
}

void read_as_mesh_file(std::string_view bytes) {
  read_as(bytes, ".h5");
}

}  // namespace pliant::fuzz
