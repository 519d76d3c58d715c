#include "io/history_reader.hpp"

#include "base/text.hpp"

#include <algorithm>
#include <fnmatch.h>
#include <fstream>
#include <limits>
#include <utility>

namespace pliant {
namespace {

/// The cells of a line; removes the quotes around a cell, and one of two inside.
std::vector<std::string> cells_of(std::string_view line) {
  std::vector<std::string> cells(1);
  bool is_quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"') {
      const bool is_pair = is_quoted && i + 1 < line.size() && line[i + 1] == '"';
      if (is_pair) cells.back() += line[i++];
      if (!is_pair) is_quoted = !is_quoted;
    } else if (line[i] == ',' && !is_quoted) {
      cells.emplace_back();
    } else {
      cells.back() += line[i];
    }
  }
  return cells;
}

/// A unit and the columns that have it, as patterns of fnmatch.
struct UnitOfColumns {
  const char* unit;
  std::vector<const char*> columns;
};

}  // namespace

std::string_view unit_of_column(const std::string& name) {
  static const std::vector<UnitOfColumns> all{
      {"s", {"time", "dt"}},
      {"J", {"*_energy", "*_work", "dissipated_*", "numerical_dissipation", "load_potential", "energy_balance_error"}},
      {"N s", {"p[xyz]", "*_j[xyz]"}},
      {"N m s", {"L[xyz]"}},
      {"N", {"*_f[xyz]", "*_tension", "*_force"}},
      {"N m", {"*_t[xyz]"}},
      {"m", {"*_[xyz]", "*_u[xyz]", "*_length", "*_travel", "*gap_min"}},
      {"rad", {"*_angle"}},
      {"m/s", {"*_v[xyz]"}},
      {"rad/s", {"*_w[xyz]"}},
      {"Pa", {"*_pressure"}},
      {"m^3", {"*_volume"}},
  };
  const auto fits = [&](const char* pattern) { return fnmatch(pattern, name.c_str(), 0) == 0; };
  const auto found =
      std::ranges::find_if(all, [&](const UnitOfColumns& of) { return std::ranges::any_of(of.columns, fits); });
  return found == all.end() ? "" : found->unit;
}

const std::vector<double>* HistoryTable::find(std::string_view name) const {
  const auto found = std::ranges::find(names, name);
  return found == names.end() ? nullptr : &columns[static_cast<std::size_t>(found - names.begin())];
}

HistoryTable read_history(const std::filesystem::path& file) {
  HistoryTable history;
  std::ifstream stream(file);
  std::string line;
  if (!std::getline(stream, line)) return history;
  history.names = cells_of(line);
  history.columns.resize(history.names.size());
  // A line without its end is still being written.
  while (std::getline(stream, line) && !stream.eof()) {
    const auto cells = cells_of(line);
    if (cells.size() != history.names.size()) break;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      history.columns[i].push_back(parse_number(cells[i]).value_or(std::numeric_limits<double>::quiet_NaN()));
    }
  }
  return history;
}

}  // namespace pliant
