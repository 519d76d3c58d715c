#include "mesh/mesh.hpp"

#include "mesh/distribute.hpp"
#include "mesh/dual_graph.hpp"
#include "mesh/gmsh_import.hpp"
#include "mesh/measure.hpp"
#include "mesh/repair.hpp"
#include "petsc/collective.hpp"
#include "petsc/session.hpp"

#include <cmath>

namespace pliant {
namespace {

void require_sane(const MeshSource& source) {
  std::vector<std::string> reasons;
  if (source.size && !(*source.size > 0.0 && std::isfinite(*source.size)))
    reasons.push_back("its size must be a positive length");
  if (!(source.scale > 0.0 && std::isfinite(source.scale))) reasons.push_back("its scale must be a positive number");
  if (source.refine < 0) reasons.push_back("refine must be 0 or a positive number of refinements");
  if (!reasons.empty()) throw MeshDefect(reasons);
}

void require_enough_cells(std::size_t num_cells, int size) {
  if (num_cells >= static_cast<std::size_t>(size)) return;
  throw MeshDefect("it has " + std::to_string(num_cells) + " tetrahedra for " + std::to_string(size) +
                   " ranks, and every rank needs one: run on fewer ranks or mesh it finer");
}

/// All that rank 0 does alone.
MeshParts prepare(const MeshSource& source, int size, MeshReport& report) {
  require_sane(source);
  MeshParts parts{import_mesh(source), 0, {}};
  report.notices = std::move(parts.mesh.notices);
  for (double& x : parts.mesh.coordinates) x *= source.scale;
  parts.num_vertices = repair(parts.mesh, report);
  if (source.refine > 0 && parts.mesh.geometry_order() == 2) {
    throw MeshDefect(
        "refine cannot be used with curved second-order elements: mesh it finer in gmsh, or use first-order elements");
  }
  require_enough_cells(parts.mesh.num_cells(), size);
  const DualGraph graph(parts.mesh);
  check_connections(parts.mesh, graph, parts.num_vertices, report);
  parts.part = graph.partition(size, report.edge_cut);
  return parts;
}

MeshParts prepare_or_reject(const MeshSource& source, int size, MeshReport& report) {
  try {
    return prepare(source, size, report);
  } catch (const MeshDefect& defect) {
    std::vector<Diagnostic> diagnostics;
    for (const auto& reason : defect.reasons()) {
      diagnostics.push_back({source.where, "mesh file '" + source.file + "': " + reason});
    }
    throw InputError(std::move(diagnostics));
  }
}

constexpr char field_end = '\x1f';

/// The groups of rank 0 on every rank.
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

/// Names and numbers of components of rank 0's data on every rank.
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
  on_root(comm, [&] { parts = prepare_or_reject(source, num_ranks(comm), mesh.report); });
  mesh.groups = shared_groups(comm, parts.mesh);
  mesh.cell_data = shared_cell_data(comm, parts.mesh);
  distribute(comm, std::move(parts), source.refine, mesh);
  measure(comm, mesh);
  return mesh;
}

}  // namespace pliant
