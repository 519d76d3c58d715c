/// Histories of runs, with what a label in a plot says of their columns.
#pragma once

#include "io/history_reader.hpp"

#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace pliant {

/// What the column `time` of a history counts.
enum class Abscissa {
  time,         ///< [s]
  load_factor,  ///< of a static run
  path          ///< length of the path of a static run by arc length
};

/// "time [s]", "load factor", "length of the path".
std::string axis_label(Abscissa abscissa);
/// "t = 0.5 s", "load factor 0.5".
std::string instant_text(Abscissa abscissa, double value);

/// A column of `output.history`.
struct FieldColumn {
  std::string name;
  std::string title;  ///< "max of von_mises_stress in beam"
  std::string unit;   ///< empty if it is not known
};

/// Those of a run, and what its time is; `input`: the text of its run.yaml. None, and time, if it cannot be read.
std::vector<FieldColumn> columns_from_fields(const std::string& input);
Abscissa abscissa_of(const std::string& input);

struct LabelledHistory {
  std::string label;
  HistoryTable table;
  Abscissa abscissa = Abscissa::time;
  std::map<std::string, std::string> units = {};  ///< of columns that the input names

  /// SI; empty for counts and where it is unknown.
  std::string unit(const std::string& column) const;
};

/// `input`: the text of its run.yaml.
LabelledHistory labelled_history(std::string label, HistoryTable table, const std::string& input);
/// A history.csv and the run.yaml next to it, if there is one. Not collective.
LabelledHistory read_labelled_history(std::string label, const std::filesystem::path& file);

/// Label of the axis of all of them: "time [s]", "load factor"; "time [s] or load factor" if they differ.
std::string axis_label(std::span<const LabelledHistory> histories);
/// The unit in the first history that knows one.
std::string unit_of_column(std::span<const LabelledHistory> histories, const std::string& column);
/// "tip_z [m]".
std::string with_unit(std::span<const LabelledHistory> histories, const std::string& column);

}  // namespace pliant
