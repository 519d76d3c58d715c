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

#include "io/companion_series.hpp"

#include <cstdint>
#include <span>
#include <string>
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

/// Adds obstacles to a result. All members that write are collective; a failure throws FileError on every rank.
class ObstacleWriter {
 public:
  /// Continues the list of frames of an earlier run up to `last_step`; -1: there is none. `bodies`, which owns the
  /// files, must outlive the object. Collective.
  ObstacleWriter(MPI_Comm comm, const ResultWriter& bodies, std::string title, const OutputObstacles& obstacles,
                 std::int64_t last_step);

  /// Adds a frame before the bodies' frame is added; `points`: the current positions, or empty if no obstacle has
  /// moved. Collective.
  void write_frame(double time, std::int64_t step, std::span<const double> points);
  /// Returns when the list of frames is on disk; the numbers follow with ResultWriter::sync. Collective.
  void sync() const { series_.sync(); }

 private:
  MPI_Comm comm_;
  CompanionSeries series_;
};

}  // namespace pliant
