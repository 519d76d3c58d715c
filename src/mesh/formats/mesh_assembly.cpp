#include "mesh/formats/mesh_assembly.hpp"

#include "mesh/element_type.hpp"
#include "mesh/mesh_collector.hpp"
#include "mesh/mesh_file.hpp"

#include <algorithm>
#include <set>

namespace pliant {
namespace {

constexpr int point_type = 15;

bool is_tetrahedron(int type) {
  return type == tetrahedron_4 || type == tetrahedron_10;
}

}  // namespace

void MeshAssembly::add_node(std::size_t tag, const std::array<double, 3>& position) {
  node_tags_.push_back(tag);
  coordinates_.insert(coordinates_.end(), position.begin(), position.end());
}

std::size_t MeshAssembly::add_element(int type, std::size_t tag, std::span<const std::size_t> nodes, std::size_t line) {
  types_.push_back(type);
  tags_.push_back(tag);
  lines_.push_back(line);
  element_nodes_.insert(element_nodes_.end(), nodes.begin(), nodes.end());
  first_node_.push_back(element_nodes_.size());
  return types_.size() - 1;
}

void MeshAssembly::add_data(CellField data, std::vector<std::size_t> element_tags) {
  data_.emplace_back(std::move(data), std::move(element_tags));
}

std::span<const std::size_t> MeshAssembly::nodes(std::size_t element) const {
  return std::span(element_nodes_).subspan(first_node_[element], first_node_[element + 1] - first_node_[element]);
}

std::vector<MeshAssembly::Facet> MeshAssembly::boundary() const {
  std::vector<Facet> facets;  // with sorted nodes
  for (std::size_t e = 0; e < types_.size(); ++e) {
    if (!is_tetrahedron(types_[e])) continue;
    for (const auto& [i, j, k] : local_facets) {
      const auto at = [&](int n) { return nodes(e)[static_cast<std::size_t>(n)]; };
      Facet facet{{at(i), at(j), at(k)}, e};
      std::ranges::sort(facet.nodes);
      facets.push_back(facet);
    }
  }
  std::ranges::sort(facets, {}, &Facet::nodes);
  std::vector<Facet> result;
  for (auto first = facets.begin(); first != facets.end();) {
    const auto last = std::find_if(first, facets.end(), [&](const Facet& f) { return f.nodes != first->nodes; });
    if (last - first == 1) result.push_back(*first);
    first = last;
  }
  return result;
}

SerialMesh MeshAssembly::finish(const std::function<std::string(std::size_t)>& place) {
  MeshCollector collector(std::move(node_tags_), std::move(coordinates_));
  for (auto* members : {&members_, &node_members_}) {
    std::ranges::sort(*members);
    members->erase(std::unique(members->begin(), members->end()), members->end());
  }
  std::set<std::pair<int, int>> groups;  // dimension and set
  auto member = members_.begin();
  for (std::size_t e = 0; e < types_.size(); ++e) {
    std::vector<int> sets;
    for (; member != members_.end() && member->first == e; ++member) sets.push_back(member->second);
    for (const int s : sets) groups.emplace(element_types[static_cast<std::size_t>(types_[e])].dimension, s);
    try {
      collector.add(types_[e], tags_[e], nodes(e), sets);
    } catch (const MeshDefect& defect) {
      throw MeshDefect(place(lines_[e]) + ": element " + std::to_string(tags_[e]) + ": " + defect.what());
    }
  }
  for (const auto& [tag, set] : node_members_) {
    groups.emplace(0, set);
    collector.add(point_type, 0, std::span(&tag, 1), std::span(&set, 1));
  }
  for (const auto& [dimension, set] : groups) {
    const auto name = names_.find(set);
    if (name != names_.end()) collector.name_group(dimension, set, name->second);
  }
  for (auto& [data, tags] : data_) collector.add_data(std::move(data), std::move(tags));
  SerialMesh mesh = collector.finish(Ungrouped::kept);
  mesh.notices.insert(mesh.notices.begin(), notices_.begin(), notices_.end());
  return mesh;
}

void swap_last_two(std::span<std::size_t> nodes) {
  std::swap(nodes[8], nodes[9]);
}

void mirror_tetrahedron(std::span<std::size_t> nodes) {
  std::swap(nodes[1], nodes[2]);
  if (nodes.size() < 10) return;
  std::swap(nodes[4], nodes[6]);  // edges 0-1 and 0-2
  std::swap(nodes[8], nodes[9]);  // edges 2-3 and 1-3
}

}  // namespace pliant
