/// Numbers that are taken from histories: "max(tip_z)".
#pragma once

#include "study/labelled_history.hpp"

#include <span>
#include <string>
#include <vector>

namespace pliant {

/// FUNCTION(COLUMN) of a history, over the rows that have a number in this column.
struct RunNumber {
  std::string name;  ///< as the user calls it
  std::string column;
  bool is_instant = false;  ///< a time, not a value of the column
  double (*function)(const std::vector<double>& time, const std::vector<double>& values) = nullptr;

  /// NaN if the history has no such column, or no number in it.
  double of(const HistoryTable& history) const;
  /// SI; empty if unknown.
  std::string unit(std::span<const LabelledHistory> histories) const;
};

/// Reads "max(tip_z)" or "height=max(tip_z)". Throws InputError that says what is expected; `option` is where the text
/// was given.
RunNumber parse_run_number(const std::string& text, const std::string& option);

}  // namespace pliant
