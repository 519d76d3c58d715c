#include "mesh/gmsh/meshing.hpp"

#include "base/vector3.hpp"
#include "mesh/gmsh/closed_surface.hpp"
#include "mesh/gmsh/extract.hpp"
#include "mesh/gmsh/local_sizes.hpp"
#include "mesh/gmsh/session.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>
#include <gmsh.h>

namespace pliant {
namespace {

/// Makes `size` the target everywhere: disables all other sizes and prescribed divisions.
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

/// Removes the mesh that a script has generated, so that gmsh meshes again. Entities that exist only as a mesh are
/// kept.
void forget_mesh() {
  gmsh::vectorpair entities;
  gmsh::model::getEntities(entities);
  const auto is_discrete = [](const auto& entity) {
    std::string type;
    gmsh::model::getType(entity.first, entity.second, type);
    return type.starts_with("Discrete");
  };
  if (std::ranges::none_of(entities, is_discrete)) gmsh::model::mesh::clear();
}

/// Rejects a size in the wrong unit, with which gmsh would fill the memory before it gives up.
void require_feasible(double size) {
  constexpr double most_cells = 1e9;  // the index range, with edges counted
  std::array<double, 6> b{};
  gmsh::model::getBoundingBox(-1, -1, b[0], b[1], b[2], b[3], b[4], b[5]);
  const double num_cells = 8.5 * ((b[3] - b[0]) / size) * ((b[4] - b[1]) / size) * ((b[5] - b[2]) / size);
  if (!(num_cells > most_cells)) return;
  throw MeshDefect(fmt::format(
      "with elements of size {:g} there would be about {:.1g} in its bounding box of {:g} x {:g} x {:g} (before "
      "`scale`): check the unit of `size`, and `scale`",
      size, num_cells, b[3] - b[0], b[4] - b[1], b[5] - b[2]));
}

void generate(const MeshSource& source) {
  if (source.size) {
    require_feasible(*source.size);
    impose_size(*source.size);
  }
  impose_local_sizes(source.sizes, source.size);
  gmsh::model::mesh::generate(3);
  std::string build;
  gmsh::option::getString("General.BuildOptions", build);
  gmsh::model::mesh::optimize(build.find("Netgen") != std::string::npos ? "Netgen" : "");
}

/// Makes solids that touch share their interface, so that their meshes conform.
void join_solids(bool has_shells) {
  gmsh::vectorpair solids;
  gmsh::model::getEntities(solids, 3);
  if (solids.empty() && has_shells) return;
  if (solids.empty()) throw MeshDefect("it contains no solid, only surfaces or curves: export the solid body");
  if (solids.size() < 2) return;
  gmsh::model::occ::removeAllDuplicates();
  gmsh::model::occ::synchronize();
}

/// Whether the nodes of a face are off the plane of three of them by more than rounding.
bool is_curved(int face) {
  std::vector<std::size_t> tags;
  std::vector<double> x, parameters;
  gmsh::model::mesh::getNodes(tags, x, parameters, 2, face, true, false);
  const auto from_first = [&](std::size_t n) {
    return Vector3<double>{x[3 * n] - x[0], x[3 * n + 1] - x[1], x[3 * n + 2] - x[2]};
  };
  Vector3<double> along{}, normal{};  // to the farthest node; across the largest triangle with it
  for (std::size_t n = 0; n < tags.size(); ++n) {
    if (norm(from_first(n)) > norm(along)) along = from_first(n);
  }
  for (std::size_t n = 0; n < tags.size(); ++n) {
    const Vector3<double> across = cross(along, from_first(n));
    if (norm(across) > norm(normal)) normal = across;
  }
  constexpr double flatness = 1e-6;
  for (std::size_t n = 0; n < tags.size(); ++n) {
    if (std::abs(dot(normal, from_first(n))) > flatness * norm(normal) * norm(along)) return true;
  }
  return false;
}

/// Whether a volume of the geometry has a curved face. Those of a mesh are as that is.
bool has_curved_faces() {
  gmsh::vectorpair faces;
  gmsh::model::getEntities(faces, 2);
  return std::ranges::any_of(faces, [](const auto& face) {
    std::string type;
    gmsh::model::getType(2, face.second, type);
    if (type == "Plane" || type.starts_with("Discrete")) return false;
    std::vector<int> volumes, curves;
    gmsh::model::getAdjacencies(2, face.second, volumes, curves);
    return !volumes.empty() && is_curved(face.second);
  });
}

SerialMesh extracted(const GmshSession& gmsh) {
  SerialMesh mesh;
  gmsh.run("return its mesh", [&] {
    mesh = extract_mesh();
    mesh.is_straightened = mesh.geometry_order() == 1 && has_curved_faces();
  });
  return mesh;
}

double mean_edge(const SerialMesh& mesh) {
  double sum = 0.0;
  for (std::size_t c = 0; c < mesh.num_cells(); ++c) {
    for (const auto& [i, j] : local_edges) {
      const double* x = mesh.node(mesh.cells[4 * c + static_cast<std::size_t>(i)]);
      const double* y = mesh.node(mesh.cells[4 * c + static_cast<std::size_t>(j)]);
      sum += std::hypot(x[0] - y[0], x[1] - y[1], x[2] - y[2]);
    }
  }
  return sum / static_cast<double>(6 * mesh.num_cells());
}

/// Divisions of gmsh's built-in kernel (Transfinite, Layers) cannot be removed through its interface, and small
/// features need small elements.
void notice_other_size(SerialMesh& mesh, const MeshSource& source) {
  if (mesh.num_cells() == 0) return;
  const double mean = mean_edge(mesh);
  if (!source.size || !source.sizes.empty() || (mean < 1.5 * *source.size && mean > 0.6 * *source.size)) return;
  mesh.notices.push_back(
      fmt::format("the mean element size is {:.2g} m instead of the requested {:g} m: the shape needs it, or the "
                  "file prescribes divisions (Transfinite, Layers)",
                  source.scale * mean, source.scale * *source.size));
}

SerialMesh mesh_script(const GmshSession& gmsh, const MeshSource& source) {
  gmsh.run("read it", [&] { gmsh::open(source.file); });
  if (source.size || !source.sizes.empty()) gmsh.run("mesh it again", forget_mesh);
  gmsh.run("mesh it", [&] { generate(source); });
  return extracted(gmsh);
}

SerialMesh mesh_cad(const GmshSession& gmsh, const MeshSource& source) {
  gmsh::option::setString("Geometry.OCCTargetUnit", "M");
  gmsh.run("read it", [&] { gmsh::open(source.file); });
  gmsh.run("join its solids", [&] { join_solids(!source.added_shells.empty()); });
  gmsh.run("mesh it", [&] { generate(source); });
  SerialMesh mesh = extracted(gmsh);
  if (!source.size) mesh.notices.push_back("no size is given: gmsh chose one, about a tenth of the body's diagonal");
  return mesh;
}

SerialMesh mesh_surface(const GmshSession& gmsh, const MeshSource& source) {
  gmsh.run("read it", [&] { gmsh::open(source.file); });
  gmsh.run("make volumes from it", [&] { add_enclosed_volumes(source.size ? Triangles::remesh : Triangles::keep); });
  gmsh.run("mesh the inside of the surface", [&] { generate(source); });
  return extracted(gmsh);
}

SerialMesh mesh_geometry(const MeshSource& source, Geometry kind) {
  const GmshSession gmsh;
  SerialMesh mesh = kind == Geometry::script ? mesh_script(gmsh, source)
                    : kind == Geometry::cad  ? mesh_cad(gmsh, source)
                                             : mesh_surface(gmsh, source);
  notice_other_size(mesh, source);
  return mesh;
}

constexpr int triangle_type = 2, second_order_triangle_type = 9;  // gmsh's

/// The corners of all triangles, three nodes each, as a mesh without cells.
SerialMesh triangle_corners(const std::string& file) {
  const GmshSession gmsh;
  SerialMesh corners;
  gmsh.run("read it", [&] { gmsh::merge(file); });
  gmsh.run("return its triangles", [&] {
    std::vector<std::size_t> node_tags;
    std::vector<double> coordinates, parameters;
    gmsh::model::mesh::getNodes(node_tags, coordinates, parameters, -1, -1, false, false);
    std::map<std::size_t, std::size_t> place;
    for (std::size_t n = 0; n < node_tags.size(); ++n) place[node_tags[n]] = n;
    for (const auto& [type, width] : {std::pair{triangle_type, 3}, {second_order_triangle_type, 6}}) {
      std::vector<std::size_t> tags, nodes;
      gmsh::model::mesh::getElementsByType(type, tags, nodes);
      for (std::size_t e = 0; e < tags.size(); ++e) {
        for (std::size_t a = 0; a < 3; ++a) {
          const std::size_t n = place.at(nodes[e * static_cast<std::size_t>(width) + a]);
          corners.coordinates.insert(corners.coordinates.end(), &coordinates[3 * n], &coordinates[3 * n] + 3);
        }
      }
    }
  });
  return corners;
}

}  // namespace
}  // namespace pliant

const pliant::GmshModule pliant_gmsh{pliant::mesh_geometry, pliant::triangle_corners};
