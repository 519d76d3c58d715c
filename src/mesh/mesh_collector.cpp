#include "mesh/mesh_collector.hpp"

#include "mesh/element_type.hpp"
#include "mesh/source_checks.hpp"

#include <algorithm>
#include <limits>

namespace pliant {
namespace {

constexpr const char* cure_for_elements =
    "in gmsh use no Recombine, no hexahedral subdivision, and Mesh.ElementOrder 1 or 2";

std::string name_of(int type) {
  return element_types[static_cast<std::size_t>(type)].name;
}

}  // namespace

MeshCollector::MeshCollector(std::vector<std::size_t> node_tags, std::vector<double> coordinates) : number_(node_tags) {
  mesh_.node_tags = std::move(node_tags);
  mesh_.coordinates = std::move(coordinates);
}

SerialGroup& MeshCollector::group(int dimension, int tag) {
  if (last_ == nullptr || last_->group.dimension != dimension || last_->group.tag != tag) {
    last_ = &groups_.try_emplace({dimension, tag}, SerialGroup{{dimension, tag, ""}, {}}).first->second;
  }
  return *last_;
}

void MeshCollector::name_group(int dimension, int tag, const std::string& name) {
  require_plain_name(name);
  group(dimension, tag).group.name = name;
}

void MeshCollector::add(int type, std::size_t tag, std::span<const std::size_t> nodes, std::span<const int> physicals) {
  const int dimension = element_types[static_cast<std::size_t>(type)].dimension;
  Count& count = found_[type];
  ++(physicals.empty() ? count.ungrouped : count.grouped);
  if (!is_usable(type)) return;
  if (dimension == 3) return add_cell(type, tag, nodes, physicals);
  for (const int physical : physicals) {
    auto& members = group(dimension, physical).members;
    for (std::size_t i = 0; i <= static_cast<std::size_t>(dimension); ++i) members.push_back(number_(nodes[i]));
  }
}

void MeshCollector::add_cell(int type, std::size_t tag, std::span<const std::size_t> nodes,
                             std::span<const int> physicals) {
  const auto cell = static_cast<PetscInt>(mesh_.num_cells());
  for (std::size_t i = 0; i < 4; ++i) mesh_.cells.push_back(number_(nodes[i]));
  if (type == tetrahedron_10) {
    for (std::size_t i = 4; i < 10; ++i) mesh_.mid_nodes.push_back(number_(nodes[i]));
  }
  mesh_.cell_tags.push_back(tag);
  if (physicals.empty()) ungrouped_.push_back(cell);
  for (const int physical : physicals) group(3, physical).members.push_back(cell);
}

void MeshCollector::add_data(CellField data, std::vector<std::size_t> element_tags) {
  if (std::ranges::find(mesh_.cell_data, data.name, &CellField::name) != mesh_.cell_data.end()) {
    mesh_.notices.push_back("there are several $ElementData '" + data.name + "'; the first one is used");
    return;
  }
  mesh_.cell_data.push_back(std::move(data));
  data_tags_.push_back(std::move(element_tags));
}

void MeshCollector::sort_data_by_cell() {
  if (mesh_.cell_data.empty()) return;
  std::vector<std::pair<std::size_t, std::size_t>> cell_of_tag;
  for (std::size_t c = 0; c < mesh_.num_cells(); ++c) cell_of_tag.emplace_back(mesh_.cell_tags[c], c);
  std::ranges::sort(cell_of_tag);
  for (std::size_t d = 0; d < mesh_.cell_data.size(); ++d) {
    CellField& data = mesh_.cell_data[d];
    const auto size = static_cast<std::size_t>(data.components);
    std::vector<double> sorted(size * mesh_.num_cells(), std::numeric_limits<double>::quiet_NaN());
    for (std::size_t e = 0; e < data_tags_[d].size(); ++e) {
      const auto found =
          std::ranges::lower_bound(cell_of_tag, data_tags_[d][e], {}, &std::pair<std::size_t, std::size_t>::first);
      if (found == cell_of_tag.end() || found->first != data_tags_[d][e]) continue;
      std::copy_n(data.values.begin() + static_cast<std::ptrdiff_t>(size * e), size,
                  sorted.begin() + static_cast<std::ptrdiff_t>(size * found->second));
    }
    data.values = std::move(sorted);
  }
}

bool MeshCollector::has_grouped_cells() const {
  for (const auto& [type, count] : found_) {
    if (element_types[static_cast<std::size_t>(type)].dimension == 3 && count.grouped > 0) return true;
  }
  return false;
}

void MeshCollector::reject_other_elements(bool groups_only) const {
  std::string text;
  for (const auto& [type, count] : found_) {
    const bool is_volume = element_types[static_cast<std::size_t>(type)].dimension == 3;
    const std::size_t used = count.grouped + (is_volume && !groups_only ? count.ungrouped : 0);
    if (is_usable(type) || used == 0) continue;
    text += (text.empty() ? "" : ", ") + std::to_string(used) + " of type " + name_of(type);
  }
  if (text.empty()) return;
  throw MeshDefect("only tetrahedra of order 1 or 2 are supported, but there are also other elements: " + text + "; " +
                   cure_for_elements);
}

void MeshCollector::reject_without_tetrahedra() {
  std::string text;
  for (const auto& [type, count] : found_) {
    text += (text.empty() ? "" : ", ") + std::to_string(count.grouped + count.ungrouped) + " of type " + name_of(type);
  }
  const auto has_triangles = [](const auto& entry) { return entry.first.first == 2 && !entry.second.members.empty(); };
  if (std::ranges::none_of(groups_, has_triangles)) throw no_tetrahedra(text.empty() ? "nodes" : text);
  mesh_.only = text;
}

void MeshCollector::drop_ungrouped_cells() {
  const std::size_t num_mid = mesh_.mid_nodes.size() / mesh_.num_cells();
  std::vector<PetscInt> renumbered(mesh_.num_cells(), 0);
  for (const PetscInt cell : ungrouped_) renumbered[static_cast<std::size_t>(cell)] = -1;
  std::size_t kept = 0;
  for (std::size_t c = 0; c < renumbered.size(); ++c) {
    if (renumbered[c] < 0) continue;
    for (std::size_t i = 0; i < 4; ++i) mesh_.cells[4 * kept + i] = mesh_.cells[4 * c + i];
    for (std::size_t i = 0; i < num_mid; ++i) mesh_.mid_nodes[num_mid * kept + i] = mesh_.mid_nodes[num_mid * c + i];
    mesh_.cell_tags[kept] = mesh_.cell_tags[c];
    renumbered[c] = static_cast<PetscInt>(kept++);
  }
  mesh_.cells.resize(4 * kept);
  mesh_.mid_nodes.resize(num_mid * kept);
  mesh_.cell_tags.resize(kept);
  for (auto& [key, g] : groups_) {
    if (key.first != 3) continue;
    for (auto& cell : g.members) cell = renumbered[static_cast<std::size_t>(cell)];
  }
  mesh_.notices.push_back(std::to_string(ungrouped_.size()) +
                          " tetrahedra are in no physical volume and were left out");
}

SerialMesh MeshCollector::finish(Ungrouped ungrouped) {
  const bool groups_only = ungrouped == Ungrouped::left_out && has_grouped_cells();
  reject_other_elements(groups_only);
  if (mesh_.cells.empty()) reject_without_tetrahedra();
  if (!mesh_.mid_nodes.empty() && mesh_.mid_nodes.size() != 6 * mesh_.num_cells()) {
    throw MeshDefect("it mixes first- and second-order tetrahedra: mesh all volumes with the same Mesh.ElementOrder");
  }
  if (groups_only && !ungrouped_.empty()) drop_ungrouped_cells();
  sort_data_by_cell();
  for (auto& [key, g] : groups_) {
    if (g.members.empty()) mesh_.notices.push_back(describe(g.group) + " has no elements");
    mesh_.groups.push_back(std::move(g));
  }
  groups_.clear();
  last_ = nullptr;
  return std::move(mesh_);
}

}  // namespace pliant
