#include "mesh/gmsh_import.hpp"

#include "mesh/closed_surface.hpp"
#include "mesh/gmsh_extract.hpp"
#include "mesh/gmsh_session.hpp"
#include "mesh/msh_reader.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>

#include <gmsh.h>

namespace pliant {
namespace {

enum class Kind { mesh, script, cad, surface };

Kind kind_of(const std::string& file) {
  std::string extension = std::filesystem::path(file).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  if (extension == ".msh") return Kind::mesh;
  if (extension == ".geo") return Kind::script;
  if (extension == ".step" || extension == ".stp" || extension == ".brep") return Kind::cad;
  if (extension == ".stl") return Kind::surface;
  throw MeshDefect(
      "its extension says nothing I can read: meshes are .msh; geometry is .geo, .step, .stp, .brep or .stl");
}

void require_readable(const std::string& file) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) throw MeshDefect("there is no such file");
  if (std::filesystem::is_directory(file, error)) throw MeshDefect("this is a directory, not a file");
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw FileError("mesh file '" + file + "' cannot be opened: no permission to read it");
  if (stream.peek() == std::ifstream::traits_type::eof()) throw MeshDefect("it is empty");
}

/// Makes `size` the target everywhere: nothing else may give a size, and nothing may prescribe a division.
void impose_size(double size) {
  const auto set = [](const char* option, double value) { gmsh::option::setNumber(option, value); };
  set("Mesh.MeshSizeFactor", 1);
  set("Mesh.MeshSizeFromPoints", 0);
  set("Mesh.MeshSizeFromCurvature", 0);
  set("Mesh.MeshSizeFromParametricPoints", 0);
  set("Mesh.MeshSizeExtendFromBoundary", 0);
  set("Mesh.MeshSizeMin", size);
  set("Mesh.MeshSizeMax", size);
  gmsh::model::mesh::removeConstraints();
}

void generate(const std::optional<double>& size) {
  if (size) impose_size(*size);
  gmsh::model::mesh::generate(3);
  std::string build;
  gmsh::option::getString("General.BuildOptions", build);
  gmsh::model::mesh::optimize(build.find("Netgen") != std::string::npos ? "Netgen" : "");
}

/// Solids that touch share their interface from now on, so that their meshes fit together.
void join_solids() {
  gmsh::vectorpair solids;
  gmsh::model::getEntities(solids, 3);
  if (solids.empty()) throw MeshDefect("there is no solid in it, only surfaces or curves: export the solid body");
  if (solids.size() < 2) return;
  gmsh::model::occ::removeAllDuplicates();
  gmsh::model::occ::synchronize();
}

SerialMesh extracted(const GmshSession& gmsh) {
  SerialMesh mesh;
  gmsh.run("give its mesh", [&] { mesh = extract_mesh(); });
  return mesh;
}

SerialMesh mesh_script(const GmshSession& gmsh, const MeshSource& source) {
  gmsh.run("make sense of it", [&] { gmsh::open(source.file); });
  gmsh.run("mesh it", [&] { generate(source.size); });
  return extracted(gmsh);
}

SerialMesh mesh_cad(const GmshSession& gmsh, const MeshSource& source) {
  gmsh::option::setString("Geometry.OCCTargetUnit", "M");
  gmsh.run("make sense of it", [&] { gmsh::open(source.file); });
  gmsh.run("join its solids", [] { join_solids(); });
  gmsh.run("mesh it", [&] { generate(source.size); });
  SerialMesh mesh = extracted(gmsh);
  if (!source.size) mesh.notices.push_back("no size is given: gmsh chose it, about a tenth of the body's diagonal");
  return mesh;
}

SerialMesh mesh_surface(const GmshSession& gmsh, const MeshSource& source) {
  gmsh.run("make sense of it", [&] { gmsh::open(source.file); });
  gmsh.run("make volumes of it", [&] { add_enclosed_volumes(source.size ? Triangles::remesh : Triangles::keep); });
  gmsh.run("mesh the inside of the surface", [&] { generate(source.size); });
  return extracted(gmsh);
}

}  // namespace

SerialMesh import_mesh(const MeshSource& source) {
  const Kind kind = kind_of(source.file);
  require_readable(source.file);
  if (kind == Kind::mesh) return read_msh(source.file);
  const GmshSession gmsh;
  switch (kind) {
    case Kind::script:
      return mesh_script(gmsh, source);
    case Kind::cad:
      return mesh_cad(gmsh, source);
    default:
      return mesh_surface(gmsh, source);
  }
}

}  // namespace pliant
