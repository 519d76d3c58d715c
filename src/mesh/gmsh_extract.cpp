#include "mesh/gmsh_extract.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

#include <gmsh.h>

namespace pliant {
namespace {

// Element types of gmsh by dimension: first order, second order.
constexpr std::array<std::array<int, 2>, 4> simplex_types{{{15, 15}, {1, 8}, {2, 9}, {4, 11}}};

/// From gmsh's node tags, which may have gaps, to 0, 1, 2, ... A dense table unless the tags are sparse.
class NodeNumbering {
 public:
  explicit NodeNumbering(const std::vector<std::size_t>& tags) {
    const std::size_t largest = tags.empty() ? 0 : *std::max_element(tags.begin(), tags.end());
    if (largest < 8 * tags.size() + 1024) {
      dense_.assign(largest + 1, -1);
      for (std::size_t i = 0; i < tags.size(); ++i) dense_[tags[i]] = static_cast<PetscInt>(i);
    } else {
      sparse_.resize(tags.size());
      for (std::size_t i = 0; i < tags.size(); ++i) sparse_[i] = {tags[i], static_cast<PetscInt>(i)};
      std::sort(sparse_.begin(), sparse_.end());
    }
  }
  PetscInt operator()(std::size_t tag) const {
    PetscInt i = -1;
    if (!dense_.empty()) {
      if (tag < dense_.size()) i = dense_[tag];
    } else {
      const auto found = std::lower_bound(sparse_.begin(), sparse_.end(), std::pair<std::size_t, PetscInt>(tag, 0));
      if (found != sparse_.end() && found->first == tag) i = found->second;
    }
    if (i < 0)
      throw MeshDefect("an element refers to node " + std::to_string(tag) + ", which the file does not define");
    return i;
  }

 private:
  std::vector<PetscInt> dense_;
  std::vector<std::pair<std::size_t, PetscInt>> sparse_;
};

struct Elements {
  std::vector<int> types;
  std::vector<std::vector<std::size_t>> tags;
  std::vector<std::vector<std::size_t>> nodes;
};

Elements elements_of(int dimension, int entity) {
  Elements e;
  gmsh::model::mesh::getElements(e.types, e.tags, e.nodes, dimension, entity);
  return e;
}

std::string element_name(int type) {
  std::string name;
  int dimension = 0, order = 0, num_nodes = 0, num_primary = 0;
  std::vector<double> local;
  gmsh::model::mesh::getElementProperties(type, name, dimension, order, num_nodes, local, num_primary);
  return name;
}

struct GroupEntities {
  PhysicalGroup group;
  std::vector<int> entities;
};

std::vector<GroupEntities> physical_groups() {
  gmsh::vectorpair dim_tags;
  gmsh::model::getPhysicalGroups(dim_tags);
  std::vector<GroupEntities> groups;
  for (const auto& [dimension, tag] : dim_tags) {
    GroupEntities g{{dimension, tag, ""}, {}};
    gmsh::model::getPhysicalName(dimension, tag, g.group.name);
    gmsh::model::getEntitiesForPhysicalGroup(dimension, tag, g.entities);
    std::sort(g.entities.begin(), g.entities.end());
    g.entities.erase(std::unique(g.entities.begin(), g.entities.end()), g.entities.end());
    groups.push_back(std::move(g));
  }
  return groups;
}

/// The volumes to take: those in physical volumes, or all if there are no physical volumes.
std::vector<int> used_volumes(const std::vector<GroupEntities>& groups) {
  std::set<int> used;
  for (const auto& g : groups) {
    if (g.group.dimension == 3) used.insert(g.entities.begin(), g.entities.end());
  }
  if (used.empty()) {
    gmsh::vectorpair all;
    gmsh::model::getEntities(all, 3);
    for (const auto& volume : all) used.insert(volume.second);
  }
  return {used.begin(), used.end()};
}

[[noreturn]] void reject_without_tetrahedra(const std::map<int, std::size_t>& found) {
  std::vector<int> types;
  gmsh::model::mesh::getElementTypes(types);
  std::string text = "there are no tetrahedra in it";
  if (types.empty() && found.empty()) {
    throw MeshDefect(text + ", nor any other elements: mesh the geometry in three dimensions (gmsh -3)");
  }
  text += ", only ";
  for (std::size_t i = 0; i < types.size(); ++i) text += (i == 0 ? "" : ", ") + element_name(types[i]);
  throw MeshDefect(text + ": mesh it in three dimensions (gmsh -3); a .geo needs a Volume");
}

[[noreturn]] void reject_other_elements(const std::map<int, std::size_t>& found) {
  std::string text = "only tetrahedra of order 1 or 2 can be used, but there are also:";
  for (const auto& [type, count] : found) text += " " + std::to_string(count) + " of type " + element_name(type) + ",";
  text.back() = '.';
  throw MeshDefect(text + " In gmsh: no Recombine, Mesh.SubdivisionAlgorithm = 0, Mesh.ElementOrder = 1 or 2");
}

void append_cells(SerialMesh& mesh, const Elements& e, std::size_t which, const NodeNumbering& number) {
  const std::size_t per_cell = e.types[which] == simplex_types[3][0] ? 4 : 10;
  const auto& tags = e.tags[which];
  const auto& nodes = e.nodes[which];
  mesh.cell_tags.insert(mesh.cell_tags.end(), tags.begin(), tags.end());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    (i % per_cell < 4 ? mesh.cells : mesh.mid_nodes).push_back(number(nodes[i]));
  }
}

/// Cells of the used volumes, and for each volume the range of its cells.
std::map<int, std::pair<PetscInt, PetscInt>> read_cells(SerialMesh& mesh, const std::vector<int>& volumes,
                                                        const NodeNumbering& number) {
  std::map<int, std::pair<PetscInt, PetscInt>> ranges;
  std::map<int, std::size_t> others;
  for (const int volume : volumes) {
    const auto begin = static_cast<PetscInt>(mesh.num_cells());
    const Elements e = elements_of(3, volume);
    for (std::size_t t = 0; t < e.types.size(); ++t) {
      if (e.tags[t].empty()) continue;
      if (e.types[t] == simplex_types[3][0] || e.types[t] == simplex_types[3][1]) {
        append_cells(mesh, e, t, number);
      } else {
        others[e.types[t]] += e.tags[t].size();
      }
    }
    ranges[volume] = {begin, static_cast<PetscInt>(mesh.num_cells())};
  }
  if (!others.empty()) reject_other_elements(others);
  if (mesh.cells.empty()) reject_without_tetrahedra(others);
  if (!mesh.mid_nodes.empty() && mesh.mid_nodes.size() != 6 * mesh.num_cells()) {
    throw MeshDefect("it mixes first- and second-order tetrahedra: mesh all volumes with the same Mesh.ElementOrder");
  }
  return ranges;
}

/// Corner nodes of the facets of one entity, dimension + 1 each.
void append_facets(std::vector<PetscInt>& corners, int dimension, int entity, const NodeNumbering& number) {
  const Elements e = elements_of(dimension, entity);
  const auto num_corners = static_cast<std::size_t>(dimension) + 1;
  for (std::size_t t = 0; t < e.types.size(); ++t) {
    if (e.tags[t].empty()) continue;
    const auto& known = simplex_types[static_cast<std::size_t>(dimension)];
    if (std::find(known.begin(), known.end(), e.types[t]) == known.end()) {
      reject_other_elements({{e.types[t], e.tags[t].size()}});
    }
    const std::size_t per_facet = e.nodes[t].size() / e.tags[t].size();
    for (std::size_t i = 0; i < e.nodes[t].size(); ++i) {
      if (i % per_facet < num_corners) corners.push_back(number(e.nodes[t][i]));
    }
  }
}

}  // namespace

SerialMesh extract_mesh() {
  SerialMesh mesh;
  std::vector<double> parameters;
  gmsh::model::mesh::getNodes(mesh.node_tags, mesh.coordinates, parameters, -1, -1, false, false);
  const NodeNumbering number(mesh.node_tags);
  const std::vector<GroupEntities> groups = physical_groups();
  const auto ranges = read_cells(mesh, used_volumes(groups), number);
  for (const auto& g : groups) {
    SerialGroup group{g.group, {}};
    for (const int entity : g.entities) {
      if (g.group.dimension == 3) {
        const auto [begin, end] = ranges.at(entity);
        const std::size_t old = group.members.size();
        group.members.resize(old + static_cast<std::size_t>(end - begin));
        std::iota(group.members.begin() + static_cast<std::ptrdiff_t>(old), group.members.end(), begin);
      } else {
        append_facets(group.members, g.group.dimension, entity, number);
      }
    }
    mesh.groups.push_back(std::move(group));
  }
  return mesh;
}

}  // namespace pliant
