#include "mesh/formats/abaqus_sets.hpp"

#include "mesh/element_type.hpp"

#include <algorithm>
#include <array>
#include <optional>

namespace pliant {
namespace {

/// Corners of faces S1 to S4 of a tetrahedron.
constexpr std::array<std::array<std::size_t, 3>, 4> abaqus_faces{{{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}}};

class GroupMaker {
 public:
  GroupMaker(AbaqusModel& model, const LineReader& lines) : model_(model), lines_(lines) {}

  void make() {
    for (const AbaqusSet& set : model_.element_sets.all()) add_elements(set);
    for (const AbaqusSurface& surface : model_.surfaces) {
      for (const AbaqusSide& side : surface.sides) add_side(surface, side);
    }
    for (const AbaqusSet& set : model_.node_sets.all()) add_nodes(set);
  }

 private:
  int group(const std::string& name) {
    const auto [place, is_new] = groups_.try_emplace(in_capitals(name), static_cast<int>(groups_.size()) + 1);
    if (is_new) model_.mesh.name_set(place->second, name);
    return place->second;
  }

  std::size_t element(std::size_t label, std::size_t line, const std::string& what) const {
    const auto found = model_.elements.find(label);
    if (found != model_.elements.end()) return found->second;
    lines_.fail(line, what + " has element " + std::to_string(label) + ", which the file does not define");
  }

  void add_elements(const AbaqusSet& set) {
    std::optional<int> id;
    for (const std::size_t label : set.labels) {
      const std::size_t e = element(label, set.line, "element set " + in_quotes(set.name));
      if (set.is_internal || e == AbaqusModel::left_out) continue;
      if (!id) id = group(model_.element_sets.title(set));
      model_.mesh.put_element(e, *id);
      if (element_types[static_cast<std::size_t>(model_.mesh.type(e))].dimension == 2) surfaces_.insert(*id);
    }
  }

  void put_facet(std::span<const std::size_t> nodes, int id) {
    model_.mesh.put_element(model_.mesh.add_element(triangle_3, 0, nodes, 0), id);
    surfaces_.insert(id);
  }

  const std::vector<MeshAssembly::Facet>& boundary() {
    if (!boundary_) boundary_ = model_.mesh.boundary();
    return *boundary_;
  }

  void add_side(const AbaqusSurface& surface, const AbaqusSide& side) {
    const std::string what = "surface " + in_quotes(surface.name);
    std::vector<std::size_t> labels;
    if (const auto label = integer_in(side.of); label && *label > 0) {
      labels.push_back(static_cast<std::size_t>(*label));
    } else if (const AbaqusSet* set = model_.element_sets.find(surface.scope, side.of)) {
      labels = set->labels;
    } else {
      lines_.fail(side.line, what + " has the element set " + in_quotes(side.of) + ", which the file does not define");
    }
    const int id = group(surface.name);
    if (side.side.empty()) return add_outside(labels, side, id, what);
    for (const std::size_t label : labels) {
      const std::size_t e = element(label, side.line, what);
      if (e != AbaqusModel::left_out) add_face(e, side, id, what);
    }
  }

  void add_face(std::size_t e, const AbaqusSide& side, int id, const std::string& what) {
    const int type = model_.mesh.type(e), dimension = element_types[static_cast<std::size_t>(type)].dimension;
    if (dimension == 2 && (side.side == "SPOS" || side.side == "SNEG")) return add_triangle(e, id);
    const bool is_face = side.side.size() == 2 && side.side[0] == 'S' && side.side[1] >= '1' && side.side[1] <= '4';
    if (type != tetrahedron_4 && type != tetrahedron_10 && dimension == 3) return;  // refused with the mesh
    if (dimension != 3 || !is_face) {
      lines_.fail(side.line, what + " has the side " + in_quotes(side.side) + " of a " +
                                 element_types[static_cast<std::size_t>(type)].name +
                                 ": a tetrahedron has S1 to S4, a triangle SPOS and SNEG");
    }
    std::array<std::size_t, 3> corners{};
    const auto& face = abaqus_faces[static_cast<std::size_t>(side.side[1] - '1')];
    for (std::size_t i = 0; i < 3; ++i) corners[i] = model_.mesh.nodes(e)[face[i]];
    put_facet(corners, id);
  }

  void add_triangle(std::size_t e, int id) {
    model_.mesh.put_element(e, id);
    surfaces_.insert(id);
  }

  /// Without a side: all facets of the elements on the boundary of the mesh.
  void add_outside(const std::vector<std::size_t>& labels, const AbaqusSide& side, int id, const std::string& what) {
    std::unordered_set<std::size_t> own;
    for (const std::size_t label : labels) {
      const std::size_t e = element(label, side.line, what);
      if (e == AbaqusModel::left_out) continue;
      own.insert(e);
      if (element_types[static_cast<std::size_t>(model_.mesh.type(e))].dimension == 2) add_triangle(e, id);
    }
    for (const MeshAssembly::Facet& facet : boundary()) {
      if (own.contains(facet.element)) put_facet(facet.nodes, id);
    }
  }

  void add_nodes(const AbaqusSet& set) {
    for (const std::size_t label : set.labels) {
      if (model_.nodes.contains(label)) continue;
      lines_.fail(set.line, "node set " + in_quotes(set.name) + " has node " + std::to_string(label) +
                                ", which the file does not define");
    }
    if (set.is_internal || set.labels.empty()) return;
    const int id = group(model_.node_sets.title(set));
    const std::unordered_set<std::size_t> own(set.labels.begin(), set.labels.end());
    for (const std::size_t label : set.labels) model_.mesh.put_node(label, id);
    if (surfaces_.contains(id)) return;
    for (const MeshAssembly::Facet& facet : boundary()) {
      const auto is_own = [&](std::size_t node) { return own.contains(node); };
      if (std::ranges::all_of(facet.nodes, is_own)) put_facet(facet.nodes, id);
    }
  }

  AbaqusModel& model_;
  const LineReader& lines_;
  std::map<std::string, int> groups_;  // by name in capitals
  std::unordered_set<int> surfaces_;   // groups with triangles
  std::optional<std::vector<MeshAssembly::Facet>> boundary_;
};

}  // namespace

void make_unique(AbaqusSet& set) {
  std::ranges::sort(set.labels);
  set.labels.erase(std::unique(set.labels.begin(), set.labels.end()), set.labels.end());
}

void add_labels(AbaqusSet& set, std::span<const std::size_t> more) {
  if (set.labels.size() + more.size() > set.labels.capacity()) make_unique(set);
  set.labels.insert(set.labels.end(), more.begin(), more.end());
}

AbaqusSet& AbaqusSets::add(const std::string& scope, const std::string& name, std::size_t line) {
  const auto [place, is_new] = index_.try_emplace(scope + in_capitals(name), sets_.size());
  if (is_new) sets_.push_back({name, scope, false, line, {}});
  return sets_[place->second];
}

const AbaqusSet* AbaqusSets::find(const std::string& scope, const std::string& name) const {
  const std::string in_all = in_capitals(name), in_part = in_all.substr(in_all.rfind('.') + 1);
  for (const std::string& key : {scope + in_all, in_all}) {
    if (const auto found = index_.find(key); found != index_.end()) return &sets_[found->second];
  }
  if (in_part == in_all) return nullptr;
  for (const AbaqusSet& set : sets_) {  // there is one part
    if (!set.scope.empty() && in_capitals(set.name) == in_part) return &set;
  }
  return nullptr;
}

std::string AbaqusSets::title(const AbaqusSet& set) const {
  return !set.scope.empty() && index_.contains(in_capitals(set.name)) ? set.scope + set.name : set.name;
}

void assign_groups(AbaqusModel& model, const LineReader& lines) {
  GroupMaker(model, lines).make();
}

}  // namespace pliant
