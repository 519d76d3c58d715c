/// Measurements: tables as CSV files whose header names the columns and their units.
#pragma once

#include "base/error.hpp"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace pliant {

/// One of the columns that a table may have in a place.
struct ColumnForm {
  std::string_view name;
  std::string_view unit;  ///< SI
  double factor = 1.0;    ///< what is returned: factor times the value in SI, and `offset`
  double offset = 0.0;
};

/// The wanted columns of a table, equally long.
struct MeasuredColumns {
  std::vector<std::vector<double>> columns;
  std::string note;  ///< which of them have no unit in the header; empty if none
};

/// Reads a table with one column for each entry of `wanted`, the first of whose forms that the header names. A header
/// cell is `name`, `name [unit]` or `name (unit)`; without a unit the numbers are SI. Blanks in names count as
/// underscores, case does not count; other columns are left out, and so are empty lines and lines that begin with #.
/// `named`: where the input names the file, for the message that there is none. Throws InputError with every error, at
/// its line and column of the table. Not collective.
MeasuredColumns read_measurements(const std::string& file, const Location& named,
                                  std::span<const std::vector<ColumnForm>> wanted);

/// All columns of a table in SI units, called as its header calls them.
struct NumberTable {
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;  ///< equally long
  std::vector<int> lines;                    ///< of the file, for each row
};

/// Reads a table of the same form without units. Throws InputError with every error. Not collective.
NumberTable read_numbers(const std::string& file, const Location& named);

}  // namespace pliant
