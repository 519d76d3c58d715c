/// A distributed tetrahedral mesh with its named groups, as every layer above sees it.
#pragma once

#include "base/error.hpp"
#include "mesh/report.hpp"
#include "petsc/handle.hpp"

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// A physical group of gmsh (a named set of points, curves, surfaces or volumes). Groups without a name have only a
/// tag.
struct PhysicalGroup {
  int dimension = 3;  ///< 0 points, 1 curves, 2 surfaces, 3 volumes
  int tag = 0;        ///< gmsh's physical tag, unique per dimension
  std::string name;   ///< may be empty
};

/// Name of the DMLabel that marks the points of a group (value 1 on points of the group's own dimension).
std::string label_name(const PhysicalGroup& group);

/// Numbers that the file gives for its cells (elements; gmsh's $ElementData).
struct CellField {
  std::string name;
  int components = 1;
  std::vector<double> values;  ///< `components` per cell; NaN where the file has none
};

/// Whether geometry files may run programs and write files, as gmsh's language allows.
enum class Commands { refused, allowed };

/// A tetrahedron of a volume of its own, which stands for a body without a mesh.
struct AddedTetrahedron {
  std::string name;                                ///< of the volume
  std::array<std::array<double, 3>, 4> corners{};  ///< [m]; of positive volume
};

/// The inside of a closed surface as a volume of its own.
struct AddedVolume {
  std::string name;            ///< of the volume
  std::string file;            ///< of the surface; as of MeshSource, geometry or mesh
  Location where;              ///< the place in the user's input that names the file
  std::optional<double> size;  ///< target element size in the unit of the file
  double scale = 1.0;          ///< of the file's coordinates
};

/// A rod, whose segments are tetrahedra of a volume of its own, and whose ends that are held are volumes of one each
/// (mesh/rod_chain.hpp).
struct AddedRod {
  std::string name;                           ///< of the volume
  Location where;                             ///< the place in the user's input, for messages
  std::vector<std::array<double, 3>> points;  ///< along it; empty: the nodes of `curve` [m]
  std::string curve;                          ///< name or number of a physical curve; empty: none
  std::optional<std::array<double, 3>> up;    ///< direction of the first director, of any length
  std::array<double, 2> arms{};               ///< distances of the directors' points from the axis [m]
  std::array<bool, 2> has_end{};              ///< whether the sections at the first and last point are held
  /// It is a fibre, whose volume has no cells, where the cells around each of its segments are at least that thick:
  /// their volume divided by the length of the segment [m^2]. Infinite: never; 0: in any case.
  double fibre_beside = std::numeric_limits<double>::infinity();
};

/// A shell on a physical surface whose triangles bound no tetrahedron, as a volume of its own (mesh/added_shells.hpp).
struct AddedShell {
  std::string name;     ///< of the volume
  std::string surface;  ///< name or number of the physical surface
  Location where;       ///< the place in the user's input, for messages
};

/// The edges of a physical curve as the file has them, in the mesh of the volumes or not. Each is directed as the
/// curve is.
struct MeshCurve {
  struct Edge {
    std::array<double, 3> from{}, to{};  ///< [m]
  };
  PhysicalGroup group;
  std::vector<Edge> edges;
};

/// A target element size at a physical group, from where it grows linearly to the size elsewhere.
struct LocalSize {
  int dimension = 2;      ///< of the group: 0 points, 1 curves, 2 surfaces
  std::string name;       ///< or number of the group
  double size = 0.0;      ///< at the group, in the unit of the file
  double distance = 0.0;  ///< where the size elsewhere is reached, in the unit of the file
};

/// Where a mesh comes from.
struct MeshSource {
  std::string file;  ///< empty: what is added is all; .geo .step .stp .brep .stl are meshed by gmsh; .msh, .h5, .inp,
                     ///< .vtk, .vtu, .med, .bdf, .nas, .unv and .mesh are read as they are
  Location where;    ///< the place in the user's input that names the file, for messages
  std::optional<double> size;  ///< target element size in the unit of the file, where gmsh meshes it
  double scale = 1.0;          ///< coordinates are multiplied by it
  int refine = 0;              ///< uniform refinements after distribution (each cuts a tetrahedron into 8)
  Commands commands = Commands::refused;
  double time_limit = 3600.0;  ///< for gmsh [s]
  /// Names or numbers of surfaces and volumes (physical groups) whose nodes may coincide with those of other parts,
  /// because the input ties them, moves them apart or lets them touch.
  std::vector<std::string> meeting_parts = {};
  std::vector<AddedTetrahedron> added_tetrahedra = {};
  std::vector<AddedVolume> added_volumes = {};
  std::vector<AddedRod> added_rods = {};
  std::vector<AddedShell> added_shells = {};
  /// Names or numbers of physical curves wanted as Mesh::curves.
  std::vector<std::string> curves = {};
  /// For geometry that gmsh meshes; the smallest counts where several reach.
  std::vector<LocalSize> sizes = {};
  std::size_t num_added() const {
    return added_tetrahedra.size() + added_volumes.size() + added_rods.size() + added_shells.size();
  }
};

/// The distributed mesh of tetrahedra. The vertices x0 .. x3 in the transitive closure of a cell have det(x1 - x0, x2 -
/// x0, x3 - x0) > 0, on owned and ghost cells, refined or not. All cells of an owned point are on its rank.
struct Mesh {
  Handle<DM> dm;  ///< interpolated DMPlex with one layer of overlap cells (all cells that share a vertex with an owned
                  ///< cell); coordinates: three per vertex [m]; the point SF gives the owner of each point
  /// The vertices of each local cell by their index in the stratum (point - start), four per cell, positively oriented.
  std::vector<PetscInt> corners;
  int geometry_order = 1;  ///< 2: edges are curved, see edge_midpoints
  std::vector<double>
      edge_midpoints;  ///< geometry_order 2: xyz of the mid-edge node of local edge point p at 3 * (p - edge_start) [m]
  std::vector<PhysicalGroup> groups;  ///< the same on every rank
  std::vector<CellField> cell_data;   ///< the same names on every rank; values by cell point, ghosts included
  std::vector<MeshCurve> curves;      ///< MeshSource::curves, the same on every rank; not refined. None of Pliant's own
                                      ///< format, which keeps no directions
  /// Numbers of the local vertex and cell points (indexed by point - start of the stratum), ghosts included: the number
  /// in the whole mesh, from 0, however it is distributed. Children of a refined cell c have 8 c .. 8 c + 7.
  std::vector<std::int64_t> vertex_numbers, cell_numbers;
  MeshReport report;  ///< the same on every rank
};

/// Reads or generates the mesh on rank 0, repairs and checks it, partitions it with METIS, distributes and refines it.
/// Large meshes in Pliant's own format (.h5, see mesh_file.hpp) are read in parallel and partitioned on all ranks by
/// PTScotch, so that no rank holds the whole mesh. Throws InputError (file, what is wrong, what to do) or FileError,
/// the same on every rank. Collective.
Mesh read_mesh(MPI_Comm comm, const MeshSource& source);

/// Writes the mesh that read_mesh would read (without `refine`) to `file` in Pliant's own format. Returns what it
/// found: numbers of cells, vertices and repairs, and notices. Throws as read_mesh does. Not collective.
MeshReport convert_mesh(const MeshSource& source, const std::string& file);

}  // namespace pliant
