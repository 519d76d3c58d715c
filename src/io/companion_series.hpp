/// What is drawn in addition to the bodies, as a time series of its own: a group of result.h5, and a file
/// result_<name>.xdmf for ParaView and other tools. Rank 0 writes everything.
#pragma once

#include "io/result_writer.hpp"

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <petscsys.h>

namespace pliant {

/// "obstacles", "obstacles_1" for the mesh "mesh" or "/mesh", "mesh_1".
std::string group_beside(std::string_view mesh_group, std::string_view name);

/// All members that write are collective; a failure throws FileError on every rank.
class CompanionSeries {
 public:
  /// `name`: one of `companions`. `datasets`: what is the same in all frames, made by `dataset`. Continues the list of
  /// frames of an earlier run up to `last_step`; -1: there is none. `bodies`, which owns the files, must outlive the
  /// object. Collective.
  CompanionSeries(MPI_Comm comm, const ResultWriter& bodies, const std::string& name, std::string title,
                  std::vector<Dataset> datasets, std::int64_t last_step);

  /// A table that is the same on every rank, or on rank 0 at least.
  static Dataset dataset(MPI_Comm comm, std::string name, std::span<const double> values, int columns,
                         std::vector<std::pair<std::string, std::string>> attributes = {});
  static Dataset dataset(MPI_Comm comm, std::string name, std::span<const std::int64_t> values, int columns);
  static Dataset dataset(MPI_Comm comm, std::string name, std::span<const std::int32_t> values,
                         std::vector<std::pair<std::string, std::string>> attributes);

  /// One of the datasets that are the same in all frames, as XDMF refers to it.
  XdmfArray array(std::string_view name) const;
  /// A dataset of the frame of a step.
  XdmfArray array(const Dataset& dataset, std::int64_t step) const;

  /// Adds a frame, with datasets of its own if there are any; name, time and step of the grid are set here. To be
  /// called before the bodies' frame is added, so that each of these has what belongs to it. Collective.
  void write_frame(double time, std::int64_t step, std::vector<Dataset> datasets, XdmfGrid grid);
  /// Returns when the list of frames is on disk; the numbers follow with ResultWriter::sync. Collective.
  void sync() const;

 private:
  XdmfArray array_in(const std::string& group, const Dataset& dataset) const;

  MPI_Comm comm_;
  const ResultWriter& bodies_;
  std::string title_;
  std::filesystem::path file_;
  std::string group_;              // "/obstacles"
  std::vector<Dataset> datasets_;  // without their numbers
  std::string grids_;              // rank 0: the XML of the frames so far
};

}  // namespace pliant
