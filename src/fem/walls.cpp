#include "fem/walls.hpp"

#include "fem/cell_integration.hpp"
#include "mesh/chamber_walls.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <map>
#include <utility>

namespace pliant {
namespace {

/// A facet as ranks exchange it.
struct Wall {
  WallTriangle nodes{};  ///< global
  std::array<Vector3<double>, 3> places{};
  int is_of_body = 1;
};

WallTriangle sorted(WallTriangle nodes) {
  std::ranges::sort(nodes);
  return nodes;
}

}  // namespace

void orient_shells_in_walls(const NodeLayout& layout, std::span<const char> is_shell, FacetList& facets) {
  if (is_shell.empty()) return;
  const auto cells = cells_of_facets(layout, facets.nodes, facets.nodes_per_facet);
  std::vector<Wall> walls;
  bool has_shell = false;
  for (PetscInt f = 0; f < facets.size(); ++f) {
    Wall wall;
    for (std::size_t a = 0; a < 3; ++a) {
      wall.nodes[a] = layout.global_node(facets.nodes_of(f)[a]);
      wall.places[a] = layout.position(facets.nodes_of(f)[a]);
    }
    const PetscInt cell = cells[static_cast<std::size_t>(f)][0];
    wall.is_of_body = cell >= 0 && is_shell[static_cast<std::size_t>(cell)] != 0 ? 0 : 1;
    has_shell = has_shell || wall.is_of_body == 0;
    if (facets.is_owned[static_cast<std::size_t>(f)] != 0) walls.push_back(wall);
  }
  if (!any_rank(layout.comm, has_shell)) return;

  std::vector<WallTriangle> triangles;
  std::vector<char> is_of_body;
  std::map<PetscInt, Vector3<double>> places;
  for (const Wall& wall : gathered(layout.comm, walls)) {
    triangles.push_back(wall.nodes);
    is_of_body.push_back(static_cast<char>(wall.is_of_body));
    for (std::size_t a = 0; a < 3; ++a) places.emplace(wall.nodes[a], wall.places[a]);
  }
  const std::vector<WallTriangle> given = triangles;
  orient_walls(triangles, is_of_body, [&](PetscInt node) { return places.at(node); });
  std::map<WallTriangle, bool> turns;
  for (std::size_t t = 0; t < triangles.size(); ++t) turns.emplace(sorted(given[t]), triangles[t] != given[t]);
  for (PetscInt f = 0; f < facets.size(); ++f) {
    PetscInt* nodes = &facets.nodes[static_cast<std::size_t>(f * facets.nodes_per_facet)];
    const WallTriangle corners{layout.global_node(nodes[0]), layout.global_node(nodes[1]),
                               layout.global_node(nodes[2])};
    if (!turns.at(sorted(corners))) continue;
    std::swap(nodes[1], nodes[2]);
    if (facets.nodes_per_facet == 6) std::swap(nodes[3], nodes[5]);  // of the edges 01 and 02
  }
}

}  // namespace pliant
