#include "mesh/gmsh_import.hpp"

#include "mesh/formats/abaqus_reader.hpp"
#include "mesh/formats/med_reader.hpp"
#include "mesh/formats/medit_reader.hpp"
#include "mesh/formats/nastran_reader.hpp"
#include "mesh/formats/unv_reader.hpp"
#include "mesh/formats/vtk_reader.hpp"
#include "mesh/formats/vtu_reader.hpp"
#include "mesh/gmsh_module.hpp"
#include "mesh/isolated.hpp"
#include "mesh/kept_mesh.hpp"
#include "mesh/msh_reader.hpp"
#include "mesh/script_commands.hpp"
#include "mesh/source_checks.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>

namespace pliant {
namespace {

const std::map<std::string, Geometry> geometries{{".geo", Geometry::script},
                                                 {".step", Geometry::cad},
                                                 {".stp", Geometry::cad},
                                                 {".brep", Geometry::cad},
                                                 {".stl", Geometry::surface}};

/// gmsh could read most of these too, but loses all groups of other formats, takes what is left of truncated files for
/// the whole, and crashes on some.
using MeshReader = SerialMesh (*)(const std::string& file);
const std::map<std::string, MeshReader> readers{{".msh", read_msh},     {".inp", read_abaqus}, {".vtk", read_vtk},
                                                {".vtu", read_vtu},     {".mesh", read_medit}, {".bdf", read_nastran},
                                                {".nas", read_nastran}, {".unv", read_unv},    {".med", read_med}};

std::string extension_of(const std::string& file) {
  std::string extension = std::filesystem::path(file).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extension;
}

/// Rejects a truncated .brep file, which ends with the reference to its main shape. The CAD kernel does not notice that
/// the end is missing and reads on forever.
void require_whole_brep(const std::string& file) {
  constexpr std::streamoff longest_end = 64;
  std::ifstream stream(file, std::ios::binary | std::ios::ate);
  const std::streamoff size = stream.tellg();
  stream.seekg(std::max<std::streamoff>(0, size - longest_end));
  const std::string end{std::istreambuf_iterator<char>(stream), {}};
  static const std::regex reference(R"(\*\s+[+-]\d+\s+\d+\s*$)");
  if (!std::regex_search(end, reference))
    throw MeshDefect("it does not end like a .brep file: it is truncated or damaged");
}

/// In a last line without a line break, gmsh reads only the first of several commands, silently.
void require_whole_script(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string line;
  while (std::getline(stream, line)) {
    if (!stream.eof() || std::count(line.begin(), line.end(), ';') < 2) continue;  // eof: the line has no line break
    throw MeshDefect(
        "its last line has no line break, and gmsh reads only the first of the commands in it: add a line break");
  }
}

}  // namespace

namespace {

SerialMesh read_or_made(const MeshSource& source) {
  const std::string extension = extension_of(source.file);
  const auto reader = readers.find(extension);
  if (reader == readers.end() && !geometries.contains(extension)) {
    throw MeshDefect(
        "its extension is unknown: meshes are .msh, .inp, .vtk, .vtu, .med, .bdf, .nas, .unv, .mesh or .h5; geometry "
        "is "
        ".geo, .step, .stp, .brep or .stl; gmsh and meshio convert many others to .msh");
  }
  require_readable(source.file);
  if (reader != readers.end()) require_no_sizes(source);
  if (extension == ".med") return isolated({Suspect::med}, [&] { return read_med(source.file); });
  if (reader != readers.end()) return reader->second(source.file);
  if (extension == ".brep") require_whole_brep(source.file);
  if (extension == ".geo") require_whole_script(source.file);
  const auto make = [&] {
    return isolated(gmsh_isolation(source),
                    [&] { return gmsh_module().mesh_geometry(source, geometries.at(extension)); });
  };
  if (source.commands == Commands::allowed) return make();
  const LoadedFiles loaded = require_no_commands(source.file);
  return loaded.is_all ? kept_or_made(recipe_of(source, loaded.files), make) : make();
}

}  // namespace

SerialMesh import_mesh(const MeshSource& source) {
  SerialMesh mesh = read_or_made(source);
  if (mesh.cells.empty() && source.added_shells.empty()) throw no_tetrahedra(mesh.only);
  return mesh;
}

}  // namespace pliant
