/// history.csv (io/history_writer.hpp) read back.
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
  /// nullptr where there is no such column.
  const std::vector<double>* find(std::string_view name) const;
};

/// Of a run that goes on, ended early, or did not begin: the complete rows that there are. Not collective.
HistoryTable read_history(const std::filesystem::path& file);

/// "J" of elastic_energy, "N" of top_fx: by the names that docs/output.md tells; empty for numbers of things and what
/// is not known.
std::string_view unit_of_column(const std::string& name);

}  // namespace pliant
