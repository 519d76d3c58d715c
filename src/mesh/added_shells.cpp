#include "mesh/added_shells.hpp"

#include "base/text.hpp"
#include "base/vector3.hpp"
#include "mesh/added_nodes.hpp"
#include "mesh/added_volumes.hpp"
#include "mesh/chamber_walls.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace pliant {
namespace {

using Triangle = WallTriangle;

/// Height of the apex above the triangle, relative to the square root of its area.
constexpr double height_of_apex = 0.8;

Triangle sorted(Triangle nodes) {
  std::ranges::sort(nodes);
  return nodes;
}

PlaceOfNode places_of(const SerialMesh& mesh) {
  return [&mesh](PetscInt node) { return mesh.place(node); };
}

/// A facet of cells, with its corners in an order such that its normal points out of one of them.
struct CellFacet {
  Triangle outward{};
  int num_cells = 0;
};

/// By their sorted corners.
std::map<Triangle, CellFacet> facets_of_cells(const SerialMesh& mesh) {
  std::map<Triangle, CellFacet> result;
  for (std::size_t c = 0; c < mesh.num_cells(); ++c) {
    for (std::size_t without = 0; without < 4; ++without) {
      Triangle facet{};
      for (std::size_t i = 0, k = 0; i < 4; ++i) {
        if (i != without) facet[k++] = mesh.cells[4 * c + i];
      }
      CellFacet& of = result[sorted(facet)];
      const Vector3<double> a = mesh.place(facet[0]), b = mesh.place(facet[1]), d = mesh.place(facet[2]);
      if (dot(mesh.place(mesh.cells[4 * c + without]) - a, cross(b - a, d - a)) > 0.0) std::swap(facet[1], facet[2]);
      of.outward = facet;
      ++of.num_cells;
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

/// The triangles of free shells, and which of them are neighbours in one.
struct ShellTriangles {
  const AddedShell* shell = nullptr;
  std::vector<Triangle> triangles;
  std::vector<OrientedPart> parts;
};

/// What a surface of the mesh says of the orientation of the triangles of shells among its own: with the facets of
/// bodies next to them, whose normals point out of the bodies, or with others that enclose a chamber with them, into
/// which the normals point.
class ChamberVotes {
 public:
  ChamberVotes(std::span<const ShellTriangles> shells, const std::map<Triangle, CellFacet>& facets,
               const SerialMesh& mesh)
      : facets_(facets), mesh_(mesh) {
    for (const ShellTriangles& shell : shells) {
      for (const Triangle& triangle : shell.triangles) of_shells_.emplace(sorted(triangle), triangle);
    }
  }
  void ask(const SerialGroup& group) {
    std::vector<Triangle> triangles;
    std::vector<char> is_of_body;
    bool has_shell = false;
    for (std::size_t n = 0; n + 2 < group.members.size(); n += 3) {
      const Triangle corners = sorted({group.members[n], group.members[n + 1], group.members[n + 2]});
      const auto of_shell = of_shells_.find(corners);
      has_shell = has_shell || of_shell != of_shells_.end();
      const CellFacet* facet = boundary_facet(corners);
      if (of_shell != of_shells_.end() || facet != nullptr) {
        triangles.push_back(facet != nullptr ? facet->outward : of_shell->second);
        is_of_body.push_back(facet != nullptr ? 1 : 0);
      }
    }
    if (!has_shell) return;
    const std::vector<char> is_known = orient_walls(triangles, is_of_body, places_of(mesh_));
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      if (is_known[t] != 0 && is_of_body[t] == 0) wanted_.emplace(sorted(triangles[t]), triangles[t]);
    }
  }
  /// 1: the triangles of a part of a shell are to stay as they are; -1: to be turned over; 0: nothing says so, or not
  /// all of what there is says the same.
  int sign_for(const ShellTriangles& shell, const OrientedPart& part) const {
    bool stays = false, turns = false;
    for (const std::size_t t : part.triangles) {
      const auto [first, last] = wanted_.equal_range(sorted(shell.triangles[t]));
      for (auto wanted = first; wanted != last; ++wanted) {
        (is_rotation(wanted->second, shell.triangles[t]) ? stays : turns) = true;
      }
    }
    return stays == turns ? 0 : stays ? 1 : -1;
  }

 private:
  const CellFacet* boundary_facet(const Triangle& corners) const {
    const auto found = facets_.find(corners);
    return found != facets_.end() && found->second.num_cells == 1 ? &found->second : nullptr;
  }
  static bool is_rotation(const Triangle& a, const Triangle& b) {
    return b[(std::ranges::find(b, a[0]) - b.begin() + 1) % 3] == a[1];
  }

  const std::map<Triangle, CellFacet>& facets_;
  const SerialMesh& mesh_;
  std::map<Triangle, Triangle> of_shells_;    // by sorted corners
  std::multimap<Triangle, Triangle> wanted_;  // likewise, in the wanted order
};

/// Neighbours get one orientation. The normals of those that enclose a volume point into it, and those of others into
/// the chamber of a surface that they are a part of.
void orient_shells(std::span<ShellTriangles> shells, const std::map<Triangle, CellFacet>& facets,
                   const SerialMesh& mesh) {
  for (ShellTriangles& shell : shells) shell.parts = orient(shell.triangles);
  ChamberVotes votes(shells, facets, mesh);
  for (const SerialGroup& group : mesh.groups) {
    if (group.group.dimension == 2) votes.ask(group);
  }
  for (ShellTriangles& shell : shells) {
    for (const OrientedPart& part : shell.parts) {
      const bool turns = part.is_closed ? volume_behind(shell.triangles, part.triangles, places_of(mesh)) > 0.0
                                        : votes.sign_for(shell, part) < 0;
      if (!turns) continue;
      for (const std::size_t t : part.triangles) std::swap(shell.triangles[t][1], shell.triangles[t][2]);
    }
  }
}

/// The triangles of a shell; `taken`: those of shells before.
std::vector<Triangle> triangles_of(const AddedShell& shell, const std::map<Triangle, CellFacet>& facets,
                                   const SerialMesh& mesh, std::map<Triangle, const AddedShell*>& taken) {
  std::vector<Triangle> triangles;
  std::size_t num_on_cells = 0;
  const std::vector<PetscInt>& corners = surface_of(shell, mesh).members;
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
  return triangles;
}

}  // namespace

void add_shells(std::span<const AddedShell> shells, SerialMesh& mesh) {
  if (shells.empty()) return;
  const std::map<Triangle, CellFacet> facets = facets_of_cells(mesh);
  std::map<Triangle, const AddedShell*> taken;
  std::vector<ShellTriangles> all;
  for (const AddedShell& shell : shells) {
    all.push_back({&shell, triangles_of(shell, facets, mesh, taken), {}});
    if (mesh.geometry_order() == 1) continue;
    throw InputError(shell.where, fmt::format("free shell '{}' is next to second-order elements, whose edges may be "
                                              "curved: use first-order elements (Mesh.ElementOrder = 1) for the "
                                              "mesh; 'element: P2' is possible with them",
                                              shell.name));
  }
  orient_shells(all, facets, mesh);
  AddedNodes nodes(mesh);
  for (const ShellTriangles& of : all) {
    const AddedShell& shell = *of.shell;
    std::vector<PetscInt> members;
    for (const Triangle& triangle : of.triangles) {
      const Vector3<double> a = mesh.place(triangle[0]), b = mesh.place(triangle[1]), c = mesh.place(triangle[2]);
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
