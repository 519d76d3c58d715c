/// Writes history.csv: one row of numbers per completed step, on disk as soon as it is known.
#pragma once

#include "base/file.hpp"

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <petscsys.h>

namespace pliant {

/// Writes the file on rank 0. A failure throws FileError on every rank.
class HistoryWriter {
 public:
  /// Starts the file with the names of its columns and replaces an earlier one; its directory must exist. Collective.
  HistoryWriter(MPI_Comm comm, const std::filesystem::path& file, const std::vector<std::string>& columns);

  /// Continues the file of an earlier run: keeps its rows up to the one whose first column is `last`, removes later
  /// ones. Without such a file, or without `last`, it starts a new one; with other columns it throws FileError.
  /// Collective.
  HistoryWriter(MPI_Comm comm, const std::filesystem::path& file, const std::vector<std::string>& columns,
                std::optional<double> last);

  /// Adds a row, one value per column; the values of rank 0 count. Collective.
  void append(std::span<const double> row);
  /// Returns when all rows are on disk. Collective.
  void sync();

 private:
  MPI_Comm comm_;
  std::size_t num_columns_;
  std::optional<File> file_;  // on rank 0
};

/// The numbers as a line of CSV, without its end: the shortest digits that read back as the same double, whole numbers
/// without a point.
std::string csv_row(std::span<const double> values);

/// The names as a line of CSV, without its end, quoted where necessary.
std::string csv_header(const std::vector<std::string>& names);

}  // namespace pliant
