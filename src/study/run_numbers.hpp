/// Numbers that are taken from histories: "max(tip_z)".
#pragma once

#include "io/history_reader.hpp"

#include <string>
#include <vector>

namespace pliant {

/// FUNCTION(COLUMN) of a history, over the rows that have a number in this column.
struct RunNumber {
  std::string name;  ///< as the user calls it
  std::string column;
  std::string unit;  ///< SI; empty if unknown
  double (*function)(const std::vector<double>& time, const std::vector<double>& values) = nullptr;

  /// NaN if the history has no such column, or no number in it.
  double of(const HistoryTable& history) const;
};

/// Reads "max(tip_z)" or "height=max(tip_z)". Throws InputError that says what is expected; `option` is where the text
/// was given.
RunNumber parse_run_number(const std::string& text, const std::string& option);

}  // namespace pliant
