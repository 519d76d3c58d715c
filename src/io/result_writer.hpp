/// The time series of a run for ParaView and other tools: result.h5 (the data) and result.xdmf (their description).
///
/// result.h5    attributes: format "pliant-result", version, title
///   /mesh/coordinates       num_nodes x 3, reference positions X [m]
///   /mesh/cells             num_cells x 4 or 10, node numbers in VTK's order
///   /mesh/body, /mesh/rank  num_cells; attributes of body, one per line: `names`; `masses`, names of
///                           rigid bodies with neither mesh nor surface, `rigid`, those with a mesh, `rods`,
///                           `rectangular_rods`, `sections` and `shells` (OutputMesh), if there are any
///   /groups/nodes, /groups/facets, /groups/cells     groups of the mesh: a row per node of points and curves, facet of
///                           surfaces, and cell of volumes: the group, then a node, 3 or 6 nodes, or a cell; attributes
///                           of /groups, one per line: `names`, `dimensions`. "/groups_1" belongs to "/mesh_1"
///   /frames/000000/...      attributes time [s], step, mesh (its group: "/mesh"; "/mesh_1" after a restart), label
///   (what
///                           is shown in place of the time, if it is none); a dataset per field, num_nodes or num_cells
///                           x components, attributes `unit` and `location` ("node" or "cell")
///   /obstacles/..., /mechanisms/...  see obstacle_writer.hpp, mechanism_writer.hpp
///
/// Only the metadata go through HDF5, on rank 0; every rank then writes its rows directly to their place in the file.
/// The result is an ordinary HDF5 file; it depends on the number of ranks only in the order of nodes and cells. HDF5's
/// MPI-IO driver is not used: on a full disk its collective calls report success on some ranks, hang, or crash at the
/// end (seen with HDF5 1.10.8 and Open MPI 4.1.4). Here each failure is a failed system call of one rank, reported to
/// all.
///
/// A frame is linked into /frames only after its data are in the file, the file is closed after each frame, and
/// result.xdmf lists the frame last and is replaced atomically. Both files are readable at any time, during the run and
/// after it was killed.
#pragma once

#include "io/hdf5_group.hpp"
#include "io/xdmf.hpp"

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <petscsys.h>

namespace pliant {

/// Names of what a result may have in addition to the bodies (CompanionSeries).
inline constexpr std::array companions{"obstacles", "mechanisms"};

/// Version of the format of result.h5.
inline constexpr std::int64_t result_version = 1;

/// A named group of the mesh, and what this rank owns of it in numbers of the whole mesh: of dimension 0 and 1 nodes,
/// of dimension 2 the nodes of facets (3 or 6 each, corners first), of dimension 3 cells.
struct OutputGroup {
  std::string name;
  int dimension = 3;
  std::vector<std::int64_t> entries;
};

/// The rank's part of a tetrahedral mesh. Ranks own contiguous blocks of nodes and of cells, in the order of ranks.
struct OutputMesh {
  int nodes_per_cell = 4;             ///< 4: linear, 10: quadratic tetrahedra
  std::int64_t global_num_nodes = 0;  ///< the same on every rank
  std::int64_t first_node = 0;        ///< global number of the first owned node
  std::vector<double> coordinates;    ///< reference positions of the owned nodes, xyz by node [m]
  std::vector<std::int64_t>
      cells;                ///< global node numbers of the owned cells; mid-edge nodes in VTK's order 01 12 02 03 13 23
  std::vector<int> bodies;  ///< index into body_names of each owned cell
  std::vector<std::string> body_names;
  /// Names of rigid bodies with neither mesh nor surface. The cells of each are a tetrahedron, or its parts, with the
  /// corners (1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1) of the box around the ellipsoid with the body's moments
  /// of inertia.
  std::vector<std::string> masses;
  /// Names of rigid bodies with a mesh.
  std::vector<std::string> rigid;
  /// Names of rods. Each cell of one is a segment x_0, x_1, p_1, p_2, in any order: p_1 and p_2 lie at the surface,
  /// across the axis from its middle and at right angles. Those with a rectangular section, whose half sides they give;
  /// and names of their sections that are held, which are not drawn.
  std::vector<std::string> rods, rectangular_rods, sections;
  /// Names of free shells. Each cell of one is a triangle with an apex near its middle; the triangle alone is drawn.
  std::vector<std::string> shells;
  std::vector<OutputGroup> groups;  ///< without volumes that are bodies of the same name; the same names on every rank
};

enum class FieldLocation { node, cell };

/// The owned values of a field. Every rank passes the same fields in the same order.
struct OutputField {
  std::string name;
  std::string unit;  ///< "m/s"; empty if the field has none
  FieldLocation location = FieldLocation::node;
  int components = 1;              ///< 1, 3, 6 (symmetric: xx yy zz xy yz xz) or 9 (row by row)
  std::span<const double> values;  ///< components by node or cell
};

/// The place of a result: <directory>/<name>.h5 and <directory>/<name>.xdmf. A directory alone is a place too.
struct ResultPlace {
  ResultPlace(std::filesystem::path in, std::string called = "result")
      : directory(std::move(in)), name(std::move(called)) {}

  std::filesystem::path directory;
  std::string name;
};

/// Writes result.h5 and result.xdmf. All members that write are collective; a failure throws FileError on every rank.
class ResultWriter {
 public:
  /// Creates the directory if necessary, replaces an earlier result, writes the mesh; result.xdmf lists no frame yet.
  /// Collective.
  ResultWriter(MPI_Comm comm, const ResultPlace& place, std::string title, const OutputMesh& mesh);

  /// Continues the result of an earlier run, e.g. from a checkpoint: keeps its frames up to step `last_step` and
  /// removes later ones. Writes the mesh again, because ranks may now own other blocks of it. Starts a new result if
  /// there is no earlier one. Collective.
  ResultWriter(MPI_Comm comm, const ResultPlace& place, std::string title, const OutputMesh& mesh,
               std::int64_t last_step);

  /// Adds a frame. When it returns, the frame is in the file and listed, and survives the end of the program. Frames
  /// are also flushed to the disk every ten seconds. `label`: what is shown in place of the time; may be empty.
  /// Collective.
  void write_frame(double time, std::int64_t step, std::span<const OutputField> fields, const std::string& label = {});
  /// Returns when all frames have reached the disk and the file ends with them. Collective.
  void sync();

  const std::filesystem::path& xdmf_file() const { return xdmf_file_; }
  const std::filesystem::path& hdf5_file() const { return hdf5_file_; }
  /// Where a CompanionSeries of this name lists its frames: <directory>/<name>_obstacles.xdmf.
  std::filesystem::path companion_file(const std::string& companion) const;
  /// The group of this run's mesh: "mesh", "mesh_1" after a restart.
  const std::string& mesh_group() const { return mesh_; }

 private:
  void bring_to_disk();
  RowBlock rows_of(FieldLocation location) const { return location == FieldLocation::node ? nodes_ : cells_; }
  XdmfArray array(const std::string& place, XdmfArray::Number number, const RowBlock& rows, int columns) const;
  void start_files() const;
  void write_mesh(const OutputMesh& mesh) const;
  void write_groups(const OutputMesh& mesh) const;
  XdmfGrid grid_of_frame(const std::string& group, std::span<const OutputField> fields) const;

  MPI_Comm comm_;
  std::string title_;
  std::filesystem::path hdf5_file_;
  std::filesystem::path xdmf_file_;
  int nodes_per_cell_;
  RowBlock nodes_;
  RowBlock cells_;
  std::int64_t next_frame_ = 0;
  std::string mesh_ = "mesh";  // the group of this run's mesh
  std::string grids_;          // rank 0: the XML of the frames so far
  std::chrono::steady_clock::time_point synced_ = std::chrono::steady_clock::now();
};

}  // namespace pliant
