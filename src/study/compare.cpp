#include "study/compare.hpp"

#include "base/file.hpp"
#include "base/text.hpp"
#include "io/history_writer.hpp"
#include "io/result_reader.hpp"
#include "io/svg_plot.hpp"
#include "study/history_plots.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <optional>
#include <set>

#include <fmt/format.h>

namespace pliant {
namespace {

namespace fs = std::filesystem;

/// The difference of two histories of a column at the times of the first.
struct Difference {
  std::vector<double> time, value;
  double largest = 0.0, at = 0.0;
};

/// y at time t; t lies within the times, which increase.
double interpolated(const std::vector<double>& times, const std::vector<double>& y, double t) {
  const auto after = static_cast<std::size_t>(std::ranges::lower_bound(times, t) - times.begin());
  if (times[after] == t) return y[after];
  const double part = (t - times[after - 1]) / (times[after] - times[after - 1]);
  return y[after - 1] + part * (y[after] - y[after - 1]);
}

/// Nothing if one of them lacks the column, or they have no time in common.
std::optional<Difference> difference(const HistoryTable& from, const HistoryTable& to, const std::string& column) {
  const auto *t = from.find("time"), *y = from.find(column), *other_t = to.find("time"), *other_y = to.find(column);
  if (t == nullptr || y == nullptr || other_t == nullptr || other_y == nullptr || other_t->empty()) return std::nullopt;
  Difference result;
  for (std::size_t i = 0; i < t->size(); ++i) {
    const double time = (*t)[i];
    if (time < other_t->front() || time > other_t->back()) continue;
    const double value = interpolated(*other_t, *other_y, time) - (*y)[i];
    if (std::isnan(value)) continue;
    result.time.push_back(time);
    result.value.push_back(value);
    if (result.time.size() == 1 || std::abs(value) > std::abs(result.largest)) {
      result.largest = value;
      result.at = time;
    }
  }
  if (result.time.empty()) return std::nullopt;
  return result;
}

class Comparison {
 public:
  Comparison(const CompareOptions& options, Console& console) : options_(options), console_(console) {
    for (const std::string& run : options.runs) read(run);
    tell_apart();
    choose_columns();
  }

  ExitCode run() {
    const fs::path directory = options_.output;
    make_directory(directory);
    std::string table = csv_header({"column", "unit", "run", "largest_difference", "time", "relative_to_range"}) + "\n";
    console_.print(fmt::format("largest differences from {}:", histories_[0].label));
    const ColumnPlots drawn(histories_, directory);
    std::size_t plots = 0, num_equal = 0, num_close = 0;
    for (const std::string& column : columns_) {
      Plot plot{column + ", differences from " + histories_[0].label,
                axis_label(histories_),
                with_unit(histories_, column),
                {}};
      plot.scale = Scale::linear;
      const double rounding = drawn.rounding_of(column);
      double largest = 0.0;
      for (auto other = std::next(histories_.begin()); other != histories_.end(); ++other) {
        const auto found = difference(histories_[0].table, other->table, column);
        if (!found) {
          console_.print(fmt::format("  {}: {} and {} do not both have it, or have no time in common", column,
                                     histories_[0].label, other->label));
          largest = HUGE_VAL;
          continue;
        }
        largest = std::max(largest, std::abs(found->largest));
        const double relative = relative_to_range(column, found->largest, rounding);
        if (std::abs(found->largest) > rounding) print_difference(column, other->label, *found, relative);
        table += csv_header({column, unit_of_column(histories_, column), other->label}) + "," +
                 csv_row(std::vector<double>{found->largest, found->at, relative}) + "\n";
        plot.series.push_back({other->label, found->time, found->value});
      }
      num_equal += largest == 0.0 ? 1 : 0;
      num_close += largest > 0.0 && largest <= rounding ? 1 : 0;
      plots += drawn.draw(column) ? 1 : 0;
      if (largest <= rounding || plot.series.empty()) continue;
      write_text_atomically(directory / (file_name_of(column) + "_difference.svg"), svg(plot));
      ++plots;
    }
    print_equal(num_equal, num_close);
    write_text_atomically(directory / "compare.csv", table);
    console_.print(fmt::format("results: {0}/compare.csv, {1} plots {0}/*.svg", directory.string(), plots));
    return ExitCode::done;
  }

 private:
  void read(const std::string& run) {
    const fs::path path = run;
    if (!fs::exists(path))
      throw FileError(fmt::format("no result: '{}' does not exist{}", run, results_elsewhere(path, "history.csv")));
    const fs::path file = fs::is_directory(path) ? path / "history.csv" : path;
    // "out/a/." and "out/a/" are called a.
    const fs::path named = fs::is_directory(path) ? fs::weakly_canonical(path) : path.parent_path();
    histories_.push_back(read_labelled_history(named.filename().empty() ? run : named.filename().string(), file));
    const HistoryTable& table = histories_.back().table;
    if (table.num_rows() == 0 || table.find("time") == nullptr) {
      throw InputError({run, 0, 0}, "it has no history: give the directory of a result, or its history.csv" +
                                        results_elsewhere(path, "history.csv"));
    }
    const std::vector<double>& time = *table.find("time");
    if (!std::ranges::is_sorted(time)) {
      throw InputError({run, 0, 0}, "its times do not increase; give the directory of one run, or its history.csv");
    }
    if (histories_.back().abscissa != histories_.front().abscissa) {
      throw InputError({run, 0, 0},
                       fmt::format("its rows are at values of {}, and those of '{}' at values of {}: compare runs of "
                                   "one kind",
                                   axis_label(histories_.back().abscissa), options_.runs.front(),
                                   axis_label(histories_.front().abscissa)));
    }
  }

  void print_difference(const std::string& column, const std::string& run, const Difference& found,
                        double relative) const {
    console_.print(fmt::format("  {}: {:+.6g} in {} at {}{}", with_unit(histories_, column), found.largest, run,
                               instant_text(histories_[0].abscissa, found.at),
                               std::isnan(relative) ? "" : fmt::format(", {:.2g} of its range", relative)));
  }

  /// `exactly`, and those besides that are equal up to rounding.
  void print_equal(std::size_t exactly, std::size_t nearly) const {
    const auto in_words = [&](std::size_t count) {
      const std::string many = count == 1 ? "1 column is" : fmt::format("{} columns are", count);
      return count == columns_.size() && count > 1 ? "all " + many : many;
    };
    if (exactly > 0) console_.print(fmt::format("  {} equal", in_words(exactly)));
    if (nearly > 0) console_.print(fmt::format("  {} equal up to rounding", in_words(nearly)));
  }

  /// Runs of the same name are called by what the user gave, and the same runs by their numbers too.
  void tell_apart() {
    const auto are_distinct = [&] {
      std::set<std::string> labels;
      return std::ranges::all_of(histories_, [&](const auto& history) { return labels.insert(history.label).second; });
    };
    if (are_distinct()) return;
    for (std::size_t i = 0; i < histories_.size(); ++i) histories_[i].label = options_.runs[i];
    if (are_distinct()) return;
    for (std::size_t i = 0; i < histories_.size(); ++i) histories_[i].label += fmt::format(" ({})", i + 1);
  }

  void choose_columns() {
    const std::vector<std::string> all = columns_of(histories_);
    for (const std::string& column : options_.columns) {
      if (std::ranges::find(all, column) != all.end()) continue;
      throw InputError({"--of " + column, 0, 0}, "no run has this column" + did_you_mean(column, all));
    }
    columns_ = options_.columns;
    if (!columns_.empty()) return;
    std::ranges::copy_if(all, std::back_inserter(columns_), [](const auto& name) { return !is_bookkeeping(name); });
  }

  /// The difference as a fraction of the range of the column in the first run; NaN if that is rounding or unknown.
  double relative_to_range(const std::string& column, double value, double rounding) const {
    const auto* y = histories_[0].table.find(column);
    if (y == nullptr || y->empty()) return NAN;
    const auto [low, high] = std::ranges::minmax(*y);
    return high - low > rounding ? std::abs(value) / (high - low) : NAN;
  }

  const CompareOptions& options_;
  Console& console_;
  std::vector<LabelledHistory> histories_;
  std::vector<std::string> columns_;
};

}  // namespace

ExitCode compare_command(const CompareOptions& options, Console& console) {
  return Comparison(options, console).run();
}

}  // namespace pliant
