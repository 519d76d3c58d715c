/// An unstructured grid of VTK, whichever way it is written.
#pragma once

#include "mesh/serial_mesh.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace pliant {

/// Numbers of cells.
struct VtkArray {
  std::string name;
  std::size_t components = 1;
  bool has_integers = false;
  std::vector<double> values;
};

struct VtkGrid {
  std::vector<double> points;              ///< xyz of each
  std::vector<std::int64_t> connectivity;  ///< points of all cells, one cell after another
  std::vector<std::int64_t> ends;          ///< of each cell in `connectivity`
  std::vector<std::int64_t> types;         ///< of each cell, VTK's numbers
  std::vector<VtkArray> cell_arrays;
};

/// The tetrahedra, triangles and lines of the grid. The numbers of one array of integers make the groups: of
/// "gmsh:physical", "CellEntityIds", "medit:ref" or "region", in this order, or else of the only array of one integer
/// per cell; negative numbers make none, nor does 0 in the first and the third. Arrays of real numbers are data of
/// cells. Throws MeshDefect, with the number of the cell from 0. Not collective.
SerialMesh mesh_of_grid(VtkGrid grid);

}  // namespace pliant
