#include "mesh/mesh.hpp"

#include "mesh/added_rods.hpp"
#include "mesh/added_shells.hpp"
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

/// MeshSource::curves, before repairs drop what no tetrahedron has.
std::vector<MeshCurve> wanted_curves(const SerialMesh& mesh, std::span<const std::string> wanted) {
  std::vector<MeshCurve> result;
  for (const auto& [group, members] : mesh.groups) {
    const auto names = [&, &of = group](const std::string& name) {
      return name == of.name || name == std::to_string(of.tag);
    };
    if (group.dimension != 1 || std::ranges::none_of(wanted, names)) continue;
    MeshCurve& curve = result.emplace_back(MeshCurve{group, {}});
    for (std::size_t e = 0; e < members.size(); e += 2)
      curve.edges.push_back({mesh.place(members[e]), mesh.place(members[e + 1])});
  }
  return result;
}

/// The whole mesh, repaired and checked, and its partition into `num_parts`.
MeshParts prepare(const MeshSource& source, int num_parts, MeshReport& report) {
  require_sane(source);
  MeshParts parts;
  if (!source.file.empty()) parts.mesh = import_mesh(source);
  report.notices = std::move(parts.mesh.notices);
  for (double& x : parts.mesh.coordinates) x *= source.scale;
  parts.curves = wanted_curves(parts.mesh, source.curves);
  add_volumes(source, parts.mesh);
  AddedParts added{source.num_added() - source.added_rods.size() - source.added_shells.size(), parts.mesh.num_cells()};
  add_rods(source.added_rods, parts.curves, parts.mesh);
  add_shells(source.added_shells, parts.mesh);
  added.num_of_rods = parts.mesh.num_cells() - added.first_of_rods;
  add_tetrahedra(source.added_tetrahedra, parts.mesh);
  parts.num_vertices = repair(parts.mesh, source.meeting_parts, source.added_rods, report);
  if (source.refine > 0 && parts.mesh.geometry_order() == 2) {
    throw MeshDefect(
        "refine does not support curved second-order elements: mesh it finer in gmsh, or use first-order elements");
  }
  const auto num_cells = static_cast<std::int64_t>(parts.mesh.num_cells());
  source.file.empty() ? require_enough_added_cells(num_cells, num_parts) : require_enough_cells(num_cells, num_parts);
  const DualGraph graph(parts.mesh);
  check_connections(parts.mesh, graph, parts.num_vertices, added, report);
  // Cells of shells have edges in common, not facets.
  std::optional<DualGraph> by_edges;
  if (!source.added_shells.empty()) by_edges.emplace(parts.mesh, CommonNodes::of_edges);
  parts.part = (by_edges ? *by_edges : graph).partition(num_parts, report.edge_cut);
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

/// Broadcasts the curves of rank 0.
std::vector<MeshCurve> shared_curves(MPI_Comm comm, const std::vector<MeshCurve>& of_root,
                                     const std::vector<PhysicalGroup>& groups) {
  struct Row {
    int tag;
    MeshCurve::Edge edge;
  };
  std::vector<Row> rows;
  for (const MeshCurve& curve : of_root) {
    for (const MeshCurve::Edge& edge : curve.edges) rows.push_back({curve.group.tag, edge});
  }
  std::vector<MeshCurve> result;
  for (const Row& row : gathered(comm, rows)) {
    if (result.empty() || result.back().group.tag != row.tag) {
      const auto is_meant = [&](const PhysicalGroup& group) { return group.dimension == 1 && group.tag == row.tag; };
      result.push_back({*std::ranges::find_if(groups, is_meant), {}});
    }
    result.back().edges.push_back(row.edge);
  }
  return result;
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
  if (!is_whole) telling_the_user(source, [&] { require_no_sizes(source); });
  if (is_whole) {
    on_root(comm, [&] { telling_the_user(source, [&] { parts = prepare(source, num_ranks(comm), mesh.report); }); });
  } else {
    telling_the_user(source, [&] {
      if (source.num_added() == 0) return;
      throw MeshDefect(
          "rods, free shells and rigid bodies without a mesh cannot be added to Pliant's own format: name the mesh "
          "that it was "
          "made from");
    });
    parts = read_mesh_file(comm, source);
    if (parts.held == MeshParts::Held::on_root && num_ranks(comm) > 1) {
      on_root(comm, [&] {
        telling_the_user(source,
                         [&] { parts.part = DualGraph(parts.mesh).partition(num_ranks(comm), mesh.report.edge_cut); });
      });
    }
  }
  mesh.groups = shared_groups(comm, parts.mesh);
  mesh.cell_data = shared_cell_data(comm, parts.mesh);
  if (!source.curves.empty()) mesh.curves = shared_curves(comm, parts.curves, mesh.groups);
  distribute(comm, std::move(parts), source.refine, mesh);
  measure(comm, source, mesh);
  // A serial mesh was checked as a whole; one in the own format reports only this sum over the ranks.
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
