/// Histories of several runs in common plots.
#pragma once

#include "study/labelled_history.hpp"

#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace pliant {

/// Names of all columns, in the order in which the histories bring them.
std::vector<std::string> columns_of(std::span<const LabelledHistory> histories);

/// Whether a column describes the computation (numbers of steps and iterations), not the bodies.
bool is_bookkeeping(const std::string& column);

/// A name that every file system takes.
std::string file_name_of(std::string text);

/// Plots of columns of histories, which outlive it.
class ColumnPlots {
 public:
  ColumnPlots(std::span<const LabelledHistory> histories, std::filesystem::path directory);

  /// Writes DIRECTORY/COLUMN.svg, the column of all histories over what they count as time, unless it varies in none of
  /// them. Returns whether it did. Not collective.
  bool draw(const std::string& column) const;

  /// The changes of a column that are rounding: next to the largest value of its unit; of forces, moments and the
  /// energy's balance that stay as they are, what the solver's tolerance leaves.
  double rounding_of(const std::string& column) const;

 private:
  std::span<const LabelledHistory> histories_;
  std::filesystem::path directory_;
  std::map<std::string, double> largest_;  ///< magnitude, by unit
  double work_ = 0.0;                      ///< the largest [J]
};

}  // namespace pliant
