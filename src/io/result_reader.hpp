/// Reads the time series of a run (io/result_writer.hpp), also while the run is active. Nothing here is collective.
#pragma once

#include "io/mechanism_writer.hpp"
#include "io/obstacle_writer.hpp"
#include "io/result_writer.hpp"
#include "petsc/hdf5.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace pliant {

/// One instant of the time series.
struct ResultFrame {
  std::string name;   ///< "000012"
  double time = 0.0;  ///< [s]; the load factor in a static problem
  std::int64_t step = 0;
  std::string mesh;   ///< group of its mesh: "/mesh"
  std::string label;  ///< what is shown in place of the time; empty: the time
};

/// A field's description; its values are read by ResultReader::values.
struct ResultField {
  std::string name;
  std::string unit;  ///< empty if it has none
  FieldLocation location = FieldLocation::node;
  int components = 1;
};

/// FileError if `place` is the input of a run, where one of its results or checkpoints (`wanted`) is meant.
void refuse_input(const std::filesystem::path& place, std::string_view wanted);

/// "; there are results in ...", or "; there is one in ...": where files of this name are near `place`, up to two
/// directories below it, or one above; else empty.
std::string results_elsewhere(const std::filesystem::path& place, std::string_view name);

/// Finds the numbers of a result: `place` is its directory, its result.h5 or its result.xdmf. FileError if there are
/// none.
std::filesystem::path result_file(const std::filesystem::path& place);

/// Runs `work`, which reads this file; a FileError that does not name the file is rethrown with its name in front.
void naming(const std::filesystem::path& file, const std::function<void()>& work);

/// FileError "'path' is <otherwise>" if the open file is not a result, and another one if it is of another version.
void require_result(hid_t file, const std::filesystem::path& path, std::string_view otherwise);

/// An open result. FileError wherever the file differs from what ResultWriter writes.
class ResultReader {
 public:
  explicit ResultReader(std::filesystem::path file);

  const std::string& title() const { return title_; }
  /// The frames that were complete when the file was opened.
  const std::vector<ResultFrame>& frames() const { return frames_; }
  /// A whole mesh, as on one rank. `group`: ResultFrame::mesh.
  OutputMesh mesh(const std::string& group) const;
  /// Where the obstacles of a mesh are drawn; nothing if the run had none. `group`: ResultFrame::mesh.
  std::optional<OutputObstacles> obstacles(const std::string& group) const;
  /// Positions of the points of the obstacles; where they are drawn, if they are at rest.
  std::vector<double> obstacle_points(const ResultFrame& frame) const;
  /// The lines of tendons, springs and joints; nothing if the run had none. `group`: ResultFrame::mesh.
  std::optional<OutputMechanisms> mechanisms(const std::string& group) const;
  /// Where they are in a frame; `mechanisms`: those of its mesh.
  MechanismState mechanism_state(const ResultFrame& frame, const OutputMechanisms& mechanisms) const;
  std::vector<ResultField> fields(const ResultFrame& frame) const;
  /// Components by node or cell.
  std::vector<double> values(const ResultFrame& frame, const ResultField& field) const;

 private:
  QuietHdf5 quiet_;
  std::filesystem::path path_;
  Hdf5Handle file_;
  std::string title_;
  std::vector<ResultFrame> frames_;
};

}  // namespace pliant
