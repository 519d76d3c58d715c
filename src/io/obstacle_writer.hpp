/// The surfaces of obstacles in addition to the time series of the bodies, for ParaView and other tools: in result.h5
/// (the numbers) and result_obstacles.xdmf (what they mean).
///
/// result.h5
///   /obstacles/points          num_points x 3, where they are drawn [m]
///   /obstacles/triangles       num_triangles x 3, point numbers, anticlockwise seen from outside
///   /obstacles/obstacle        num_triangles; attribute `names`: the names, one per line
///   /obstacles/frames/000040/points  positions at step 40; absent while none has moved
/// After a restart the group is called /obstacles_1, as the mesh is called /mesh_1.
#pragma once

#include "io/result_writer.hpp"

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <petscsys.h>

namespace pliant {

/// Triangles of all obstacles, the same on every rank.
struct OutputObstacles {
  std::vector<std::string> names;
  std::vector<double> points;           ///< xyz by point [m]
  std::vector<std::int64_t> triangles;  ///< three point numbers each, anticlockwise seen from outside
  std::vector<std::int32_t> obstacles;  ///< index into names of each triangle
};

/// "obstacles", "obstacles_1" for "mesh" or "/mesh", "mesh_1".
std::string obstacles_beside(std::string_view mesh_group);

/// Adds obstacles to a result. All members that write are collective; a failure throws FileError on every rank.
class ObstacleWriter {
 public:
  /// Continues the list of frames of an earlier run up to `last_step`; -1: there is none. `bodies`, which owns the
  /// files, must outlive the object. Collective.
  ObstacleWriter(MPI_Comm comm, const ResultWriter& bodies, std::string title, const OutputObstacles& obstacles,
                 std::int64_t last_step);

  /// Adds a frame; `points`: the current positions, on rank 0 at least, or empty everywhere if no obstacle has moved.
  /// To be called before the bodies' frame is added, so that each of these has its obstacles. Collective.
  void write_frame(double time, std::int64_t step, std::span<const double> points);
  /// Returns when the list of frames is on disk; the numbers follow with ResultWriter::sync. Collective.
  void sync() const;

 private:
  /// Rank 0 writes everything.
  RowBlock rows(std::int64_t num_global) const;
  XdmfArray array(const std::string& place, XdmfArray::Number number, std::int64_t num_rows, int columns) const;

  MPI_Comm comm_;
  const ResultWriter& bodies_;
  std::string title_;
  std::int64_t num_points_, num_triangles_;
  std::string group_;  // "/obstacles"
  std::string grids_;  // rank 0: the XML of the frames so far
};

}  // namespace pliant
