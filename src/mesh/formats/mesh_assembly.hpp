/// What most mesh formats hold: numbered nodes and elements, and sets of them by number or name.
#pragma once

#include "mesh/serial_mesh.hpp"

#include <array>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace pliant {

/// Takes nodes, elements and sets in any order; `finish` makes groups of the sets: volumes of their tetrahedra,
/// surfaces of their triangles, curves of their lines, and points of their nodes. A set of several kinds becomes
/// several groups of one name. All tetrahedra belong to the mesh, in a set or not.
class MeshAssembly {
 public:
  /// A facet of a tetrahedron that no other tetrahedron has; tags of its nodes, index of the element.
  struct Facet {
    std::array<std::size_t, 3> nodes;
    std::size_t element;
  };

  void add_node(std::size_t tag, const std::array<double, 3>& position);
  /// `type`: gmsh's element type, with the nodes in gmsh's order; `line`: for messages. Returns the index of the
  /// element.
  std::size_t add_element(int type, std::size_t tag, std::span<const std::size_t> nodes, std::size_t line);

  /// Sets are known by numbers from 0 on; a name is optional.
  void name_set(int set, const std::string& name) { names_[set] = name; }
  void put_element(std::size_t index, int set) { members_.emplace_back(index, set); }
  void put_node(std::size_t tag, int set) { node_members_.emplace_back(tag, set); }
  void add_data(CellField data, std::vector<std::size_t> element_tags);
  void add_notice(std::string notice) { notices_.push_back(std::move(notice)); }

  std::size_t num_elements() const { return types_.size(); }
  int type(std::size_t element) const { return types_[element]; }
  std::span<const std::size_t> nodes(std::size_t element) const;
  std::vector<Facet> boundary() const;

  /// `place`: of a line, for messages. Throws MeshDefect as MeshCollector does, with the place of a bad element.
  SerialMesh finish(const std::function<std::string(std::size_t)>& place);

 private:
  std::vector<std::size_t> node_tags_;
  std::vector<double> coordinates_;
  std::vector<int> types_;
  std::vector<std::size_t> tags_, lines_, element_nodes_, first_node_{0};
  std::vector<std::pair<std::size_t, int>> members_, node_members_;
  std::map<int, std::string> names_;
  std::vector<std::pair<CellField, std::vector<std::size_t>>> data_;
  std::vector<std::string> notices_;
};

/// Nodes of a second-order tetrahedron in gmsh's order from the order of VTK, Abaqus, Nastran, MED and Medit, which
/// swaps the last two.
void swap_last_two(std::span<std::size_t> nodes);

/// gmsh's order of the nodes of a tetrahedron whose corners 1 and 2 are exchanged: the mirror image.
void mirror_tetrahedron(std::span<std::size_t> nodes);

}  // namespace pliant
