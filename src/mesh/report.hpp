/// The results of a mesh's preflight check.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace pliant {

/// Size of a physical group in the distributed, refined mesh.
struct GroupReport {
  int dimension = 3;
  int tag = 0;
  std::string name;       ///< may be empty
  long long count = 0;    ///< points, edges, facets or cells, each counted once over all ranks
  double measure = 0.0;   ///< length [m], area [m^2] or volume [m^3]; 0 for points
  bool is_added = false;  ///< cells that stand for what the mesh of the file does not have
};

/// How many elements of each kind. Cells stand for segments and triangles, which the mesh of a file does not have.
struct ElementCounts {
  long long tetrahedra = 0;
  long long segments = 0;   ///< of rods
  long long triangles = 0;  ///< of free shells
  bool operator==(const ElementCounts&) const = default;
};

/// "493 tetrahedra, 392 triangles of shells"; "rigid bodies alone" if there are none.
std::string in_words(const ElementCounts& counts);

/// Size and quality of the tetrahedra of the whole mesh.
struct MeshReport {
  long long num_cells = 0;
  ElementCounts elements;
  long long num_vertices = 0;  ///< corners of tetrahedra, after refinement
  long long num_edges = 0;
  long long num_orphan_nodes = 0;    ///< nodes of the file that no tetrahedron uses; dropped
  long long num_inverted_cells = 0;  ///< negatively oriented in the file; reoriented
  // The following count the tetrahedra of bodies, or, if there are none, all cells.
  std::array<long long, 10>
      quality_histogram{};  ///< count per tenth of the mean-ratio quality 12 (3V)^(2/3) / sum of squared edges, 0..1
  double min_quality = 0.0;
  double min_edge = 0.0;                  ///< [m]
  double max_edge = 0.0;                  ///< [m]
  double volume = 0.0;                    ///< [m^3], of the straight tetrahedra
  std::array<double, 6> bounds{};         ///< of all cells: xmin ymin zmin xmax ymax zmax [m]
  std::vector<long long> cells_per_rank;  ///< owned
  long long edge_cut = 0;                 ///< facets shared by cells of two ranks, on the unrefined mesh
  int geometry_order = 1;                 ///< 2: curved edges
  bool is_straightened = false;           ///< straight edges along curved faces of the geometry that gmsh meshed
  std::vector<GroupReport> groups;        ///< in the order of Mesh::groups
  std::vector<std::string> notices;       ///< in plain words, e.g. "12 inverted tetrahedra were reoriented"
};

/// "[0, 1] x [0, 1] x [0, 0] m", from bounds as in MeshReport.
std::string extent_text(const std::array<double, 6>& bounds);

/// The report as aligned text of several lines, with a histogram of the quality; ends with a line break.
std::string describe(const MeshReport& report);

}  // namespace pliant
