#include "mesh/gmsh/extract.hpp"

#include "mesh/element_type.hpp"
#include "mesh/mesh_collector.hpp"

#include <cstdlib>

#include <gmsh.h>

namespace pliant {
namespace {

void extract_entity(MeshCollector& collector, int dimension, int entity) {
  std::vector<int> physicals;
  gmsh::model::getPhysicalGroupsForEntity(dimension, entity, physicals);
  if (dimension < 3 && physicals.empty()) return;
  for (int& physical : physicals) physical = std::abs(physical);
  std::vector<int> types;
  std::vector<std::vector<std::size_t>> tags, nodes;
  gmsh::model::mesh::getElements(types, tags, nodes, dimension, entity);
  for (std::size_t t = 0; t < types.size(); ++t) {
    if (static_cast<std::size_t>(types[t]) >= element_types.size()) {
      throw MeshDefect("its mesh has elements of gmsh type " + std::to_string(types[t]) +
                       ", but only tetrahedra of order 1 or 2 can be used: set Mesh.ElementOrder to 1 or 2");
    }
    const auto num_nodes = static_cast<std::size_t>(element_types[static_cast<std::size_t>(types[t])].num_nodes);
    for (std::size_t e = 0; e < tags[t].size(); ++e) {
      collector.add(types[t], tags[t][e], {&nodes[t][num_nodes * e], num_nodes}, physicals);
    }
  }
}

/// Groups that hold nothing have a name, and are not among gmsh's groups.
void name_empty_groups(MeshCollector& collector) {
  constexpr int most_tags = 10000;
  for (int dimension = 0; dimension <= 3; ++dimension) {
    for (int tag = 1; tag <= most_tags; ++tag) {
      std::string name;
      gmsh::model::getPhysicalName(dimension, tag, name);
      if (!name.empty()) collector.name_group(dimension, tag, name);
    }
  }
}

}  // namespace

SerialMesh extract_mesh() {
  std::vector<std::size_t> node_tags;
  std::vector<double> coordinates, parameters;
  gmsh::model::mesh::getNodes(node_tags, coordinates, parameters, -1, -1, false, false);
  MeshCollector collector(std::move(node_tags), std::move(coordinates));
  gmsh::vectorpair entities;
  gmsh::model::getEntities(entities);
  for (const auto& [dimension, entity] : entities) extract_entity(collector, dimension, entity);
  gmsh::vectorpair groups;
  gmsh::model::getPhysicalGroups(groups);
  for (const auto& [dimension, tag] : groups) {
    std::string name;
    gmsh::model::getPhysicalName(dimension, tag, name);
    collector.name_group(dimension, tag, name);
  }
  name_empty_groups(collector);
  return collector.finish();
}

}  // namespace pliant
