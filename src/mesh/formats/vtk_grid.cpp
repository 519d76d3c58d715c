#include "mesh/formats/vtk_grid.hpp"

#include "mesh/element_type.hpp"
#include "mesh/formats/mesh_assembly.hpp"
#include "mesh/source_checks.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace pliant {
namespace {

constexpr int vtk_tetrahedron_10 = 24;

/// gmsh's element types by VTK's.
const std::map<std::int64_t, int> gmsh_types_of_vtk{{1, 15},  {3, 1},   {21, 8},  {5, 2},   {22, 9}, {9, 3},
                                                    {23, 16}, {28, 10}, {10, 4},  {24, 11}, {12, 5}, {25, 17},
                                                    {29, 12}, {13, 6},  {26, 18}, {14, 7},  {27, 19}};

/// Names of arrays that programs give to the numbers of regions, and whether 0 means none.
struct RegionName {
  const char* name;
  bool is_zero_none;
};
constexpr std::array<RegionName, 4> region_names{
    {{"gmsh:physical", true}, {"CellEntityIds", false}, {"medit:ref", true}, {"region", false}}};

/// Numbers of cells are not regions, nor are VTK's own arrays (vtkGhostType, vtkOriginalCellIds).
bool can_be_regions(const VtkArray& array) {
  const bool is_other = array.name.starts_with("vtk") || array.name.starts_with("Global");
  return array.has_integers && array.components == 1 && !is_other;
}

/// The array whose numbers are those of the groups; null if it is not clear which, with a notice.
const VtkArray* regions_of(const VtkGrid& grid, MeshAssembly& mesh) {
  for (const auto& region : region_names) {
    const auto found = std::ranges::find_if(
        grid.cell_arrays, [&](const VtkArray& array) { return array.name == region.name && can_be_regions(array); });
    if (found != grid.cell_arrays.end()) return &*found;
  }
  const auto number = std::ranges::count_if(grid.cell_arrays, can_be_regions);
  if (number == 1) return &*std::ranges::find_if(grid.cell_arrays, can_be_regions);
  std::string names;
  for (const VtkArray& array : grid.cell_arrays) {
    if (can_be_regions(array)) names += (names.empty() ? "'" : ", '") + array.name + "'";
  }
  if (number > 1) {
    mesh.add_notice("it has several integers per cell (" + names +
                    "), and no groups were made of them: name the one of the groups 'region'");
  }
  return nullptr;
}

/// The set of each cell: the number of its region.
class RegionSets {
 public:
  explicit RegionSets(const VtkArray* regions) : regions_(regions) {
    if (regions == nullptr) return;
    for (const auto& region : region_names) is_zero_none_ |= region.name == regions->name && region.is_zero_none;
  }
  int set_of(std::size_t cell) const {
    if (regions_ == nullptr) return none;
    const double value = regions_->values[cell];
    const bool is_set = value >= (is_zero_none_ ? 1.0 : 0.0) && value <= 2e9;
    return is_set ? static_cast<int>(value) : none;
  }
  static constexpr int none = -1;

 private:
  const VtkArray* regions_;
  bool is_zero_none_ = false;
};

[[noreturn]] void fail_at_cell(std::size_t cell, const std::string& message) {
  throw MeshDefect("cell " + std::to_string(cell) + ": " + message);
}

void require_whole_grid(const VtkGrid& grid) {
  const std::size_t num_cells = grid.types.size();
  if (grid.ends.size() != num_cells) {
    throw MeshDefect("it has types of " + std::to_string(num_cells) + " cells, but points of " +
                     std::to_string(grid.ends.size()) + ": it is truncated or damaged; write or copy it again");
  }
  std::int64_t before = 0;
  const auto most = static_cast<std::int64_t>(grid.connectivity.size());
  for (std::size_t c = 0; c < num_cells; ++c) {
    if (grid.ends[c] < before || grid.ends[c] > most) {
      fail_at_cell(c, "its points are not where the file says: it is damaged; write or copy it again");
    }
    before = grid.ends[c];
  }
  for (const VtkArray& array : grid.cell_arrays) {
    require_plain_name(array.name);
    if (array.values.size() == array.components * num_cells) continue;
    throw MeshDefect("the data '" + array.name + "' have " + std::to_string(array.values.size()) + " numbers for " +
                     std::to_string(num_cells) + " cells: it is damaged; write or copy it again");
  }
}

/// The points of a cell, numbered from 1, in gmsh's order.
std::vector<std::size_t> nodes_of_cell(const VtkGrid& grid, std::size_t cell, int num_nodes) {
  const auto num_points = static_cast<std::int64_t>(grid.points.size() / 3);
  std::vector<std::size_t> nodes;
  for (std::int64_t i = cell == 0 ? 0 : grid.ends[cell - 1]; i < grid.ends[cell]; ++i) {
    const std::int64_t point = grid.connectivity[static_cast<std::size_t>(i)];
    if (point < 0 || point >= num_points) {
      fail_at_cell(cell, "it has point " + std::to_string(point) + ", but there are only " +
                             std::to_string(num_points) + " of them");
    }
    nodes.push_back(static_cast<std::size_t>(point) + 1);
  }
  if (nodes.size() != static_cast<std::size_t>(num_nodes)) {
    fail_at_cell(
        cell, "a cell of its type has " + std::to_string(num_nodes) + " points, not " + std::to_string(nodes.size()));
  }
  if (grid.types[cell] == vtk_tetrahedron_10) swap_last_two(nodes);
  return nodes;
}

}  // namespace

SerialMesh mesh_of_grid(VtkGrid grid) {
  require_whole_grid(grid);
  MeshAssembly mesh;
  const RegionSets regions(regions_of(grid, mesh));
  for (std::size_t p = 0; p < grid.points.size() / 3; ++p) {
    mesh.add_node(p + 1, {grid.points[3 * p], grid.points[3 * p + 1], grid.points[3 * p + 2]});
  }
  std::vector<std::size_t> tags;
  for (std::size_t c = 0; c < grid.types.size(); ++c) {
    tags.push_back(c + 1);
    const auto type = gmsh_types_of_vtk.find(grid.types[c]);
    if (type == gmsh_types_of_vtk.end()) {
      fail_at_cell(c, "cells of VTK's type " + std::to_string(grid.types[c]) +
                          " are not supported: only tetrahedra of order 1 (type 10) or 2 (type 24)");
    }
    const auto nodes = nodes_of_cell(grid, c, element_types[static_cast<std::size_t>(type->second)].num_nodes);
    const std::size_t index = mesh.add_element(type->second, c + 1, nodes, 0);
    if (const int set = regions.set_of(c); set != RegionSets::none) mesh.put_element(index, set);
  }
  constexpr std::size_t most_components = 9;
  for (VtkArray& array : grid.cell_arrays) {
    if (array.has_integers || array.components > most_components) continue;
    mesh.add_data({array.name, static_cast<int>(array.components), std::move(array.values)}, tags);
  }
  return mesh.finish([](std::size_t) { return std::string("its cells"); });
}

}  // namespace pliant
