/// The files that a run writes: result.h5 and result.xdmf, history.csv, run.yaml.
#pragma once

#include "io/history_writer.hpp"
#include "io/result_writer.hpp"
#include "run/history_row.hpp"
#include "run/mechanism_drawing.hpp"
#include "run/obstacle_drawing.hpp"
#include "run/simulation.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// What to keep of the files of the run that is continued.
struct Recorded {
  std::int64_t last_row = 0;    ///< step of the last row of the history
  std::int64_t last_frame = 0;  ///< step of the last frame of the result
};

/// The mesh of the model as results hold it.
OutputMesh output_mesh(const Config& config, const Model& model);

class Recorder {
 public:
  /// Creates the directory and all files, or continues the files of an earlier run. The history has columns for the
  /// ledger's mechanisms. Throws FileError on every rank. Collective.
  Recorder(const Config& config, Model& model, const Ledger& ledger, const std::optional<Recorded>& earlier);

  const std::vector<std::string>& columns() const { return row_.columns(); }
  /// Adds a row to the history, and returns it. Collective.
  std::vector<double> record(const StepRecord& record, const Ledger& ledger);
  /// Adds a frame to the result. Collective.
  void write_frame(const StepRecord& record);
  /// Returns when history and frames have reached the disk. Collective.
  void sync();

  double seconds() const { return seconds_; }
  /// The fields of the last state that was recorded.
  ResultFields& fields() { return row_.fields(); }

 private:
  Model& model_;
  HistoryRow row_;
  std::vector<std::string> names_;  // of the fields of frames
  double seconds_ = 0.0;
  ResultWriter result_;
  std::optional<ObstacleDrawing> drawing_;  // of obstacles, if there are any
  std::optional<ObstacleWriter> obstacles_;
  MechanismDrawing mechanism_drawing_;
  std::optional<MechanismWriter> mechanisms_;  // if there are any
  HistoryWriter history_;
};

}  // namespace pliant
