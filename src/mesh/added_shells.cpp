#include "mesh/added_shells.hpp"

#include "base/text.hpp"
#include "base/vector3.hpp"
#include "mesh/added_nodes.hpp"
#include "mesh/added_volumes.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <fmt/format.h>

namespace pliant {
namespace {

using Triangle = std::array<PetscInt, 3>;

/// Height of the apex above the triangle, relative to the square root of its area.
constexpr double height_of_apex = 0.8;

Triangle sorted(Triangle nodes) {
  std::ranges::sort(nodes);
  return nodes;
}

std::set<Triangle> facets_of_cells(const SerialMesh& mesh) {
  std::set<Triangle> result;
  for (std::size_t c = 0; c < mesh.num_cells(); ++c) {
    for (std::size_t without = 0; without < 4; ++without) {
      Triangle facet{};
      for (std::size_t i = 0, k = 0; i < 4; ++i) {
        if (i != without) facet[k++] = mesh.cells[4 * c + i];
      }
      result.insert(sorted(facet));
    }
  }
  return result;
}

const SerialGroup& surface_of(const AddedShell& shell, const SerialMesh& mesh) {
  std::vector<std::string> names;
  for (const SerialGroup& group : mesh.groups) {
    if (group.group.dimension != 2) continue;
    const std::string tag = std::to_string(group.group.tag);
    if (group.group.name == shell.surface || tag == shell.surface) return group;
    names.push_back(group.group.name.empty() ? tag : group.group.name);
  }
  throw InputError(shell.where,
                   fmt::format("no surface '{}' in the mesh{}; {}", shell.surface, did_you_mean(shell.surface, names),
                               names.empty() ? "the mesh has no physical surfaces" : "the mesh has: " + joined(names)));
}

Vector3<double> place(const SerialMesh& mesh, PetscInt node) {
  const double* x = mesh.node(node);
  return {x[0], x[1], x[2]};
}

/// Neighbours get one orientation; where they enclose a volume, their normals point into it.
void orient(std::vector<Triangle>& triangles, const SerialMesh& mesh) {
  std::map<std::pair<PetscInt, PetscInt>, std::vector<std::size_t>> at_edge;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      at_edge[std::minmax(triangles[t][k], triangles[t][(k + 1) % 3])].push_back(t);
    }
  }
  std::vector<char> is_done(triangles.size(), 0);
  for (std::size_t first = 0; first < triangles.size(); ++first) {
    if (is_done[first] != 0) continue;
    is_done[first] = 1;
    std::vector<std::size_t> part{first};
    bool is_closed = true;
    for (std::size_t n = 0; n < part.size(); ++n) {
      const Triangle of = triangles[part[n]];
      for (std::size_t k = 0; k < 3; ++k) {
        const PetscInt from = of[k], to = of[(k + 1) % 3];
        const auto& both = at_edge.at(std::minmax(from, to));
        is_closed = is_closed && both.size() == 2;
        if (both.size() != 2) continue;
        const std::size_t other = both[0] == part[n] ? both[1] : both[0];
        if (is_done[other] != 0) continue;
        Triangle& nodes = triangles[other];
        const auto at = static_cast<std::size_t>(std::ranges::find(nodes, from) - nodes.begin());
        if (nodes[(at + 1) % 3] == to) std::swap(nodes[1], nodes[2]);
        is_done[other] = 1;
        part.push_back(other);
      }
    }
    double volume = 0.0;
    const Vector3<double> origin = place(mesh, triangles[first][0]);
    for (const std::size_t t : part) {
      const auto& [a, b, c] = triangles[t];
      volume += dot(place(mesh, a) - origin, cross(place(mesh, b) - origin, place(mesh, c) - origin)) / 6.0;
    }
    if (!is_closed || volume <= 0.0) continue;
    for (const std::size_t t : part) std::swap(triangles[t][1], triangles[t][2]);
  }
}

}  // namespace

void add_shells(std::span<const AddedShell> shells, SerialMesh& mesh) {
  if (shells.empty()) return;
  const std::set<Triangle> facets = facets_of_cells(mesh);
  std::map<Triangle, const AddedShell*> taken;
  AddedNodes nodes(mesh);
  const bool has_middles = mesh.geometry_order() == 2;
  for (const AddedShell& shell : shells) {
    std::vector<Triangle> triangles;
    std::size_t num_on_cells = 0;
    const std::vector<PetscInt> corners = surface_of(shell, mesh).members;
    for (std::size_t n = 0; n + 2 < corners.size(); n += 3) {
      const Triangle triangle{corners[n], corners[n + 1], corners[n + 2]};
      if (facets.contains(sorted(triangle))) ++num_on_cells;
      const auto [found, is_new] = taken.try_emplace(sorted(triangle), &shell);
      if (is_new) {
        triangles.push_back(triangle);
      } else if (found->second != &shell) {
        throw InputError(shell.where, fmt::format("free shells '{}' and '{}' have triangles in common: make one of "
                                                  "them of the surface of both, or give each its own",
                                                  found->second->name, shell.name));
      }
    }
    if (num_on_cells > 0) {
      throw InputError(shell.where, fmt::format("{} of the {} triangles of surface '{}' bound tetrahedra, and those of "
                                                "a free shell do not: remove 'free: true', or make a physical surface "
                                                "of those that are free",
                                                num_on_cells, triangles.size(), shell.surface));
    }
    if (has_middles) {
      throw InputError(shell.where, fmt::format("free shell '{}' is next to second-order elements, whose edges may be "
                                                "curved: use first-order elements (Mesh.ElementOrder = 1) for the "
                                                "mesh; 'element: P2' is possible with them",
                                                shell.name));
    }
    orient(triangles, mesh);
    std::vector<PetscInt> members;
    for (const Triangle& triangle : triangles) {
      const Vector3<double> a = place(mesh, triangle[0]), b = place(mesh, triangle[1]), c = place(mesh, triangle[2]);
      const Vector3<double> normal = cross(b - a, c - a);
      const double area = 0.5 * norm(normal);
      if (!(area > 0.0)) {
        throw InputError(shell.where, fmt::format("free shell '{}' has a triangle without area at ({:g}, {:g}, {:g}): "
                                                  "mesh the surface again",
                                                  shell.name, a[0], a[1], a[2]));
      }
      const Vector3<double> apex = (1.0 / 3.0) * (a + b + c) - (height_of_apex * std::sqrt(area)) * unit(normal);
      // Its volume is positive.
      members.push_back(nodes.add_cell({triangle[0], triangle[2], triangle[1], nodes.add(apex)}, false));
    }
    add_volume_group(shell.name, std::move(members), mesh);
  }
  complete_cell_data(mesh);
}

}  // namespace pliant
