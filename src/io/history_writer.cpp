#include "io/history_writer.hpp"

#include "base/error.hpp"
#include "petsc/collective.hpp"

#include <cassert>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <fstream>

namespace pliant {
namespace {

/// The shortest digits would write a million as 1e+06; counts must look like counts.
std::string shortest(double value) {
  constexpr double whole_below = 1e15;
  char digits[32];
  const bool whole = std::abs(value) < whole_below && value == std::trunc(value);
  const auto end = whole ? std::to_chars(digits, digits + sizeof digits, static_cast<std::int64_t>(value)).ptr
                         : std::to_chars(digits, digits + sizeof digits, value).ptr;
  return {digits, end};
}

/// The lines of an earlier history that a run continuing after the row `last` keeps.
std::string kept_lines(const std::filesystem::path& path, const std::string& header, double last) {
  std::string kept = header + "\n";
  std::ifstream in(path);
  std::string line;
  if (!std::getline(in, line)) return kept;
  if (line != header) throw FileError("cannot continue '" + path.string() + "': its columns are not those of this run");
  while (std::getline(in, line)) {
    // A row without its end was cut off when the earlier run was killed.
    if (in.eof()) break;
    double first = 0;
    const auto parsed = std::from_chars(line.data(), line.data() + line.size(), first);
    if (parsed.ec != std::errc{} || first > last) break;
    kept += line + "\n";
  }
  return kept;
}

}  // namespace

HistoryWriter::HistoryWriter(MPI_Comm comm, const std::filesystem::path& file, const std::vector<std::string>& columns)
    : HistoryWriter(comm, file, columns, std::nullopt) {}

HistoryWriter::HistoryWriter(MPI_Comm comm, const std::filesystem::path& file, const std::vector<std::string>& columns,
                             std::optional<double> last)
    : comm_(comm), num_columns_(columns.size()) {
  on_root(comm_, [&] {
    if (last) write_text_atomically(file, kept_lines(file, csv_header(columns), *last));
    file_.emplace(file, last ? FileMode::append : FileMode::create);
    if (!last) file_->write(csv_header(columns) + "\n");
  });
}

void HistoryWriter::sync() {
  on_root(comm_, [&] { file_->sync(); });
}

void HistoryWriter::append(std::span<const double> row) {
  assert(row.size() == num_columns_);
  on_root(comm_, [&] { file_->append_whole(csv_row(row) + "\n"); });
}

std::string csv_row(std::span<const double> values) {
  std::string text;
  for (const double value : values) {
    if (!text.empty()) text += ',';
    text += shortest(value);
  }
  return text;
}

std::string csv_header(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) text += ',';
    if (names[i].find_first_of(",\"\r\n") == std::string::npos) {
      text += names[i];
      continue;
    }
    text += '"';
    for (const char c : names[i]) text += c == '"' ? std::string("\"\"") : std::string(1, c);
    text += '"';
  }
  return text;
}

}  // namespace pliant
