/// Tendons, springs, rods and joints in addition to the time series of the bodies, as lines, for ParaView and other
/// tools: in result.h5 (the numbers) and result_mechanisms.xdmf (what they mean).
///
/// result.h5
///   /mechanisms/points    num_points x 3, in the reference configuration [m]
///   /mechanisms/segments  num_segments x 2, point numbers; those of a tendon in order from its pulled end
///   /mechanisms/part      num_segments; attributes `names` and `kinds`, one per line: tendons ("tendon"), then springs
///                         ("spring"), then rods ("rod"), then joints (their types)
///   /mechanisms/joints    num_joints, the point where each joint is; absent without joints
///   /mechanisms/frames/000040/points, tension, axes  at step 40: positions [m]; tension of each segment, 0 of joints
///                         [N]; num_joints x 3 unit vectors, zero of joints without an axis, absent without joints
/// After a restart the group is called /mechanisms_1, as the mesh is called /mesh_1.
#pragma once

#include "io/companion_series.hpp"

#include <cstdint>
#include <string>
#include <vector>

#include <petscsys.h>

namespace pliant {

/// Lines that show tendons, springs, rods and joints, the same on every rank.
struct OutputMechanisms {
  std::vector<std::string> names;      ///< of tendons, then springs, then rods, then joints
  std::vector<std::string> kinds;      ///< of each: "tendon", "spring", "rod", or the type of a joint
  std::vector<double> points;          ///< xyz by point, in the reference configuration [m]
  std::vector<std::int64_t> segments;  ///< two point numbers each
  std::vector<std::int32_t> parts;     ///< index into names of each segment
  std::vector<std::int64_t> joints;    ///< the point where each joint is
};

/// The same at some time.
struct MechanismState {
  std::vector<double> points;    ///< xyz by point [m]
  std::vector<double> tensions;  ///< of each segment [N]
  std::vector<double> axes;      ///< xyz by joint, of unit length; zero of joints without an axis
};

/// Adds mechanisms to a result. All members that write are collective; a failure throws FileError on every rank.
class MechanismWriter {
 public:
  /// Continues the list of frames of an earlier run up to `last_step`; -1: there is none. `bodies`, which owns the
  /// files, must outlive the object. Collective.
  MechanismWriter(MPI_Comm comm, const ResultWriter& bodies, std::string title, const OutputMechanisms& mechanisms,
                  std::int64_t last_step);

  /// Adds a frame, before the bodies' frame is added. Collective.
  void write_frame(double time, std::int64_t step, const MechanismState& state);
  /// Returns when the list of frames is on disk; the numbers follow with ResultWriter::sync. Collective.
  void sync() const { series_.sync(); }

 private:
  MPI_Comm comm_;
  CompanionSeries series_;
};

}  // namespace pliant
