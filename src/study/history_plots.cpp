#include "study/history_plots.hpp"

#include "base/file.hpp"
#include "io/svg_plot.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <fnmatch.h>
#include <functional>
#include <string_view>
#include <tuple>
#include <utility>

namespace pliant {
namespace {

constexpr std::array<std::string_view, 5> bookkeeping{"step", "time", "dt", "newton_iterations", "linear_iterations"};
constexpr double rounding = 1e-12;  // of the largest value of the same unit
// What a solver's tolerance leaves where forces or energies balance, as on a closed chamber: forces do no such work
// over a metre, and Newton's method does not see such a part of the largest one.
constexpr double of_work = 1e-7, of_largest = 1e-8;
constexpr std::array<std::string_view, 3> works{"elastic_energy", "load_work", "support_work"};

/// Largest minus smallest value; 0 of none.
double extent(const std::vector<double>& values) {
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (const double value : values) {
    if (std::isfinite(value)) std::tie(low, high) = std::pair{std::min(low, value), std::max(high, value)};
  }
  return std::max(high - low, 0.0);
}

double magnitude(const std::vector<double>& values) {
  double largest = 0.0;
  for (const double value : values) largest = std::isfinite(value) ? std::max(largest, std::abs(value)) : largest;
  return largest;
}

}  // namespace

std::vector<std::string> columns_of(std::span<const LabelledHistory> histories) {
  std::vector<std::string> names;
  for (const LabelledHistory& history : histories) {
    for (const std::string& name : history.table.names) {
      if (std::ranges::find(names, name) == names.end()) names.push_back(name);
    }
  }
  return names;
}

bool is_bookkeeping(const std::string& column) {
  return std::ranges::find(bookkeeping, column) != bookkeeping.end();
}

std::string file_name_of(std::string text) {
  constexpr std::size_t longest = 100;
  const auto is_plain = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
           std::string_view("._=+-,").find(c) != std::string_view::npos;
  };
  while (text.size() > 1 && !is_plain(text.back())) text.pop_back();
  std::ranges::replace_if(text, std::not_fn(is_plain), '_');
  return text.substr(0, longest);
}

ColumnPlots::ColumnPlots(std::span<const LabelledHistory> histories, std::filesystem::path directory)
    : histories_(histories), directory_(std::move(directory)), largest_{{"rad", 1.0}} {
  for (const std::string& column : columns_of(histories_)) {
    const bool is_work = std::ranges::find(works, column) != works.end();
    double& largest = largest_[unit_of_column(histories_, column)];
    for (const LabelledHistory& history : histories_) {
      const auto* values = history.table.find(column);
      if (values == nullptr) continue;
      largest = std::max(largest, magnitude(*values));
      if (is_work) work_ = std::max(work_, magnitude(*values));
    }
  }
  largest_[""] = 0.0;  // those without a unit have nothing in common
}

double ColumnPlots::rounding_of(const std::string& column) const {
  const std::string unit = unit_of_column(histories_, column);
  const bool is_of_rotation = fnmatch("*_q[wxyz]", column.c_str(), 0) == 0;  // of unit quaternions
  double change = 0.0, largest = is_of_rotation ? 1.0 : largest_.at(unit);
  for (const LabelledHistory& history : histories_) {
    const auto* values = history.table.find(column);
    if (values == nullptr) continue;
    change = std::max(change, extent(*values));
    largest = std::max(largest, magnitude(*values));
  }
  const bool may_balance = unit == "N" || unit == "N m" || column == "energy_balance_error";
  const double left = std::max(of_work * work_, of_largest * largest_.at(unit));
  return may_balance && change <= left ? left : rounding * largest;
}

bool ColumnPlots::draw(const std::string& column) const {
  Plot plot;
  plot.title = column;
  plot.x_label = axis_label(histories_);
  plot.y_label = with_unit(histories_, column);
  plot.scale = Scale::linear;
  const double unseen = rounding_of(column);
  bool is_seen = false;
  for (const LabelledHistory& history : histories_) {
    const HistoryTable& table = history.table;
    const auto *time = table.find("time"), *values = table.find(column);
    if (time == nullptr || values == nullptr || values->empty()) continue;
    is_seen = is_seen || extent(*values) > unseen;
    plot.series.push_back({history.label, *time, *values});
  }
  if (is_seen) write_text_atomically(directory_ / (file_name_of(column) + ".svg"), svg(plot));
  return is_seen;
}

}  // namespace pliant
