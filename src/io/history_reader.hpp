/// Reads history.csv (io/history_writer.hpp).
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace pliant {

struct HistoryTable {
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;  ///< equally long; NaN where there is no number

  std::size_t num_rows() const { return columns.empty() ? 0 : columns.front().size(); }
  /// nullptr if there is no such column.
  const std::vector<double>* find(std::string_view name) const;
};

/// For a run that is active, ended early, or did not begin: the complete rows so far. Not collective.
HistoryTable read_history(const std::filesystem::path& file);

/// Units: "J" for elastic_energy, "N" for top_fx, by the column names of docs/output.md; empty for counts and unknown
/// names.
std::string_view unit_of_column(const std::string& name);

}  // namespace pliant
