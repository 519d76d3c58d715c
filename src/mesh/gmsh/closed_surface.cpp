#include "mesh/gmsh/closed_surface.hpp"

#include "mesh/disjoint_sets.hpp"
#include "mesh/element_type.hpp"
#include "mesh/node_numbering.hpp"
#include "mesh/serial_mesh.hpp"
#include "mesh/tetrahedron.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include <gmsh.h>

namespace pliant {
namespace {

using tetrahedron::Point;

// Facets that meet at more than this angle [rad] belong to different faces of the body.
constexpr double crease_angle = 40.0 * std::numbers::pi / 180.0;

struct Triangle {
  std::array<PetscInt, 3> nodes;
  int surface;
};

struct TriangleSoup {
  std::vector<Point> nodes;
  std::vector<Triangle> triangles;
};

TriangleSoup triangles_of_model() {
  std::vector<std::size_t> node_tags;
  std::vector<double> x, parameters;
  gmsh::model::mesh::getNodes(node_tags, x, parameters, -1, -1, false, false);
  const NodeNumbering number(node_tags);
  TriangleSoup soup;
  for (std::size_t i = 0; i < node_tags.size(); ++i) soup.nodes.push_back({x[3 * i], x[3 * i + 1], x[3 * i + 2]});
  gmsh::vectorpair surfaces;
  gmsh::model::getEntities(surfaces, 2);
  for (const auto& [dimension, surface] : surfaces) {
    std::vector<std::size_t> tags, nodes;
    gmsh::model::mesh::getElementsByType(triangle_3, tags, nodes, surface);
    for (std::size_t i = 0; i + 2 < nodes.size(); i += 3) {
      soup.triangles.push_back({{number(nodes[i]), number(nodes[i + 1]), number(nodes[i + 2])}, surface});
    }
  }
  return soup;
}

void require_closed(const TriangleSoup& soup) {
  if (soup.triangles.empty()) throw MeshDefect("it contains no triangles");
  std::vector<std::pair<PetscInt, PetscInt>> edges;
  for (const auto& t : soup.triangles) {
    for (std::size_t i = 0; i < 3; ++i) edges.push_back(std::minmax(t.nodes[i], t.nodes[(i + 1) % 3]));
  }
  std::sort(edges.begin(), edges.end());
  std::size_t open = 0, crowded = 0;
  for (auto first = edges.begin(); first != edges.end();) {
    const auto last = std::upper_bound(first, edges.end(), *first);
    open += last - first == 1 ? 1 : 0;
    crowded += last - first > 2 ? 1 : 0;
    first = last;
  }
  if (open == 0 && crowded == 0) return;
  throw MeshDefect("its surface is not closed: " + std::to_string(open) + " edges have one triangle instead of two, " +
                   std::to_string(crowded) +
                   " have more than two; repair it (in Blender, MeshLab or the CAD program it comes from)");
}

/// The triangles of one connected shell.
struct Shell {
  std::vector<int> surfaces;
  std::vector<Triangle> triangles;
  int depth = 0;  ///< number of shells around it
};

std::vector<Shell> connected_shells(const TriangleSoup& soup) {
  DisjointSets nodes(soup.nodes.size());
  for (const auto& t : soup.triangles) {
    for (std::size_t i = 1; i < 3; ++i)
      nodes.join(static_cast<std::size_t>(t.nodes[0]), static_cast<std::size_t>(t.nodes[i]));
  }
  std::map<std::size_t, Shell> by_root;
  for (const auto& t : soup.triangles) by_root[nodes.root(static_cast<std::size_t>(t.nodes[0]))].triangles.push_back(t);
  std::vector<Shell> shells;
  for (auto& [root, shell] : by_root) {
    for (const auto& t : shell.triangles) shell.surfaces.push_back(t.surface);
    std::sort(shell.surfaces.begin(), shell.surfaces.end());
    shell.surfaces.erase(std::unique(shell.surfaces.begin(), shell.surfaces.end()), shell.surfaces.end());
    shells.push_back(std::move(shell));
  }
  return shells;
}

/// Solid angle of the triangle seen from the origin (Van Oosterom & Strackee 1983, "The solid angle of a plane
/// triangle", eq. 8).
double solid_angle(const Point& a, const Point& b, const Point& c) {
  const double la = std::sqrt(dot(a, a)), lb = std::sqrt(dot(b, b)), lc = std::sqrt(dot(c, c));
  const double numerator = dot(a, cross(b, c));
  const double denominator = la * lb * lc + dot(a, b) * lc + dot(a, c) * lb + dot(b, c) * la;
  return 2.0 * std::atan2(numerator, denominator);
}

bool encloses(const TriangleSoup& soup, const Shell& shell, const Point& p) {
  double angle = 0.0;
  const auto from_p = [&](PetscInt node) { return soup.nodes[static_cast<std::size_t>(node)] - p; };
  for (const auto& t : shell.triangles)
    angle += solid_angle(from_p(t.nodes[0]), from_p(t.nodes[1]), from_p(t.nodes[2]));
  return std::abs(angle) > 2.0 * std::numbers::pi;  // 4 pi inside, 0 outside
}

}  // namespace

void add_enclosed_volumes(Triangles triangles) {
  require_closed(triangles_of_model());
  const bool is_remeshed = triangles == Triangles::remesh;
  gmsh::model::mesh::classifySurfaces(crease_angle, true, is_remeshed);
  if (is_remeshed) gmsh::model::mesh::createGeometry();
  const TriangleSoup soup = triangles_of_model();
  std::vector<Shell> shells = connected_shells(soup);
  const auto inside = [&](const Shell& inner, const Shell& outer) {
    return &inner != &outer &&
           encloses(soup, outer, soup.nodes[static_cast<std::size_t>(inner.triangles.front().nodes[0])]);
  };
  for (auto& inner : shells) {
    for (const auto& outer : shells) inner.depth += inside(inner, outer) ? 1 : 0;
  }
  std::vector<int> loops;
  for (const auto& shell : shells) loops.push_back(gmsh::model::geo::addSurfaceLoop(shell.surfaces));
  for (std::size_t i = 0; i < shells.size(); ++i) {
    if (shells[i].depth % 2 != 0) continue;
    std::vector<int> bounds{loops[i]};
    for (std::size_t j = 0; j < shells.size(); ++j) {
      if (shells[j].depth == shells[i].depth + 1 && inside(shells[j], shells[i])) bounds.push_back(loops[j]);
    }
    gmsh::model::geo::addVolume(bounds);
  }
  gmsh::model::geo::synchronize();
}

}  // namespace pliant
