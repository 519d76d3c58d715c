#include "mesh/mesh.hpp"

#include "mesh/added_tetrahedra.hpp"
#include "mesh/added_volumes.hpp"
#include "mesh/distribute.hpp"
#include "mesh/dual_graph.hpp"
#include "mesh/gmsh_import.hpp"
#include "mesh/measure.hpp"
#include "mesh/mesh_file.hpp"
#include "mesh/mesh_file_writer.hpp"
#include "mesh/repair.hpp"
#include "mesh/source_checks.hpp"
#include "petsc/collective.hpp"
#include "petsc/session.hpp"

#include <algorithm>
#include <iterator>

namespace pliant {
namespace {

/// The whole mesh, repaired and checked, and its partition into `num_parts`.
MeshParts prepare(const MeshSource& source, int num_parts, MeshReport& report) {
  require_sane(source);
  MeshParts parts;
  if (!source.file.empty()) parts.mesh = import_mesh(source);
  report.notices = std::move(parts.mesh.notices);
  for (double& x : parts.mesh.coordinates) x *= source.scale;
  add_volumes(source, parts.mesh);
  add_tetrahedra(source.added_tetrahedra, parts.mesh);
  parts.num_vertices = repair(parts.mesh, source.meeting_parts, report);
  if (source.refine > 0 && parts.mesh.geometry_order() == 2) {
    throw MeshDefect(
        "refine does not support curved second-order elements: mesh it finer in gmsh, or use first-order elements");
  }
  require_enough_cells(static_cast<std::int64_t>(parts.mesh.num_cells()), num_parts);
  const DualGraph graph(parts.mesh);
  check_connections(parts.mesh, graph, parts.num_vertices, source.num_added(), report);
  parts.part = graph.partition(num_parts, report.edge_cut);
  return parts;
}

constexpr char field_end = '\x1f';

/// Broadcasts the groups of rank 0.
std::vector<PhysicalGroup> shared_groups(MPI_Comm comm, const SerialMesh& mesh) {
  std::string text;
  for (const auto& [group, members] : mesh.groups) {
    text +=
        std::to_string(group.dimension) + field_end + std::to_string(group.tag) + field_end + group.name + field_end;
  }
  text = broadcast(comm, std::move(text));
  std::vector<PhysicalGroup> groups;
  std::size_t at = 0;
  const auto field = [&] {
    const std::size_t end = text.find(field_end, at);
    std::string value = text.substr(at, end - at);
    at = end + 1;
    return value;
  };
  while (at < text.size()) {
    PhysicalGroup group;
    group.dimension = std::stoi(field());
    group.tag = std::stoi(field());
    group.name = field();
    groups.push_back(std::move(group));
  }
  return groups;
}

/// Broadcasts the names and numbers of components of rank 0's data.
std::vector<CellField> shared_cell_data(MPI_Comm comm, const SerialMesh& mesh) {
  std::string text;
  for (const auto& data : mesh.cell_data) text += std::to_string(data.components) + data.name + field_end;
  text = broadcast(comm, std::move(text));
  std::vector<CellField> result;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = text.find(field_end, at);
    result.push_back({text.substr(at + 1, end - at - 1), text[at] - '0', {}});  // 1 to 9 components
    at = end + 1;
  }
  return result;
}

}  // namespace

std::string label_name(const PhysicalGroup& group) {
  constexpr std::array<const char*, 4> kinds{"point", "curve", "surface", "volume"};
  return std::string("physical ") + kinds.at(static_cast<std::size_t>(group.dimension)) + " " +
         std::to_string(group.tag);
}

Mesh read_mesh(MPI_Comm comm, const MeshSource& source) {
  Mesh mesh;
  MeshParts parts;
  const bool is_whole = !is_mesh_file(source.file);
  if (is_whole) {
    on_root(comm, [&] { telling_the_user(source, [&] { parts = prepare(source, num_ranks(comm), mesh.report); }); });
  } else {
    telling_the_user(source, [&] {
      if (source.num_added() == 0) return;
      throw MeshDefect(
          "rigid bodies without a mesh cannot be added to Pliant's own format: name the mesh that it was "
          "made from");
    });
    parts = read_mesh_file(comm, source);
  }
  mesh.groups = shared_groups(comm, parts.mesh);
  mesh.cell_data = shared_cell_data(comm, parts.mesh);
  distribute(comm, std::move(parts), source.refine, mesh);
  measure(comm, mesh);
  // A serial mesh was checked as a whole; a mesh read in blocks reports only this sum over the ranks.
  telling_the_user(source, [&] {
    if (is_whole || mesh.report.min_quality > 0.0) return;
    throw MeshDefect("it has inverted or flat tetrahedra, which `pliant mesh convert` never writes: write it again");
  });
  return mesh;
}

MeshReport convert_mesh(const MeshSource& source, const std::string& file) {
  MeshReport report;
  telling_the_user(source, [&] {
    if (!is_mesh_file(file)) throw MeshDefect("the converted mesh must be named .h5, not '" + file + "'");
    if (is_mesh_file(source.file)) throw MeshDefect("it is in Pliant's own format already");
    MeshParts parts = prepare(source, 1, report);
    report.num_cells = static_cast<long long>(parts.mesh.num_cells());
    report.num_vertices = parts.num_vertices;
    write_mesh_file(file, parts.mesh);
    std::ranges::move(parts.mesh.notices, std::back_inserter(report.notices));
  });
  return report;
}

}  // namespace pliant
