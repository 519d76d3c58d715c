/// Builds a serial mesh from elements one by one.
#pragma once

#include "mesh/node_numbering.hpp"
#include "mesh/serial_mesh.hpp"

#include <map>
#include <span>
#include <utility>

namespace pliant {

/// What becomes of tetrahedra in no physical volume where there are physical volumes: gmsh's files leave them out,
/// those of others have sets that may overlap, and keep all.
enum class Ungrouped { left_out, kept };

/// Takes all nodes at once and the elements one by one; `finish` decides which are used: the tetrahedra of the physical
/// volumes if there are any, else all.
class MeshCollector {
 public:
  /// `coordinates`: xyz per tag. Throws MeshDefect if a tag is given twice.
  MeshCollector(std::vector<std::size_t> node_tags, std::vector<double> coordinates);

  /// Names a physical group, which exists from now on, with or without elements.
  void name_group(int dimension, int tag, const std::string& name);

  /// `type`: gmsh's element type; `nodes`: the tags of its nodes; `physicals`: the tags of the groups that contain it,
  /// of the element's own dimension. Throws MeshDefect if a node does not exist.
  void add(int type, std::size_t tag, std::span<const std::size_t> nodes, std::span<const int> physicals);

  /// Data of elements, `components` numbers each; `finish` drops the values of other elements than tetrahedra. If a
  /// name is given twice, the first data count.
  void add_data(CellField data, std::vector<std::size_t> element_tags);

  /// Throws MeshDefect if there are no tetrahedra, other volume elements, or a mixture of orders.
  SerialMesh finish(Ungrouped ungrouped = Ungrouped::left_out);

 private:
  struct Count {
    std::size_t grouped = 0;
    std::size_t ungrouped = 0;
  };
  SerialGroup& group(int dimension, int tag);
  void add_cell(int type, std::size_t tag, std::span<const std::size_t> nodes, std::span<const int> physicals);
  bool has_grouped_cells() const;
  void reject_other_elements(bool groups_only) const;
  /// Unless there are triangles of groups, which may be free shells.
  void reject_without_tetrahedra();
  void drop_ungrouped_cells();
  void sort_data_by_cell();

  SerialMesh mesh_;
  NodeNumbering number_;
  std::map<std::pair<int, int>, SerialGroup> groups_;
  std::vector<PetscInt> ungrouped_;
  std::map<int, Count> found_;                       // per element type
  std::vector<std::vector<std::size_t>> data_tags_;  // elements of mesh_.cell_data, until `finish`
  SerialGroup* last_ = nullptr;
};

}  // namespace pliant
