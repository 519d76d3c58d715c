#include "study/level_results.hpp"

#include "base/file.hpp"
#include "base/limits.hpp"
#include "io/history_writer.hpp"
#include "petsc/collective.hpp"
#include "study/history_plots.hpp"

#include <array>
#include <cmath>
#include <span>

#include <fmt/format.h>

namespace pliant {

double observed_order(double coarse, double fine, double refinement) {
  return std::log(coarse / fine) / std::log(refinement);
}

LevelResults::LevelResults(std::vector<RunNumber> numbers, LevelScale scale, const std::string& input)
    : numbers_(std::move(numbers)), scale_(std::move(scale)), units_(labelled_history("", {}, input)) {}

void LevelResults::add(const std::string& method, int level, double size, std::vector<double> values) {
  levels_.push_back({method, level, size, std::move(values)});
}

bool LevelResults::is_finer(std::size_t level, std::size_t than) const {
  return level < levels_.size() && levels_[level].method == levels_[than].method;
}

double LevelResults::error(std::size_t level, std::size_t number) const {
  const double value = levels_[level].values[number];
  if (scale_.has_reference) return std::abs(value - reference_[number]);
  return is_finer(level + 1, level) ? std::abs(value - levels_[level + 1].values[number]) : nan;
}

double LevelResults::order(std::size_t level, std::size_t number) const {
  if (level == 0 || !is_finer(level, level - 1)) return nan;
  return observed_order(error(level - 1, number), error(level, number), scale_.refinement);
}

/// Three values a, b, c on meshes of which each is finer by r, with errors that fall by one factor r^p, have the limit
/// c + (c - b) / (r^p - 1), where r^p = (b - a) / (c - b) (Roache 1998, Verification and Validation, 5.4).
std::string LevelResults::limit(std::size_t last, std::size_t number) const {
  if (last < 2 || !is_finer(last, last - 2)) return "";
  const auto value = [&](std::size_t level) { return levels_[level].values[number]; };
  const double before = value(last - 1) - value(last - 2), change = value(last) - value(last - 1);
  const double factor = before / change;
  if (!(factor > 1.0) || !std::isfinite(factor)) return "";
  return fmt::format("{}: {:.6g} at h = 0 (Richardson extrapolation, order {:.2f})", levels_[last].method,
                     value(last) + change / (factor - 1.0), std::log(factor) / std::log(scale_.refinement));
}

std::string LevelResults::label(std::size_t number) const {
  const std::string unit = numbers_[number].unit(std::span(&units_, 1));
  return unit.empty() ? numbers_[number].name : fmt::format("{} [{}]", numbers_[number].name, unit);
}

std::vector<std::string> LevelResults::tables() const {
  const auto shown = [](double x, const char* format) {
    return std::isfinite(x) ? fmt::format(fmt::runtime(format), x) : std::string("-");
  };
  std::vector<std::string> lines;
  for (std::size_t n = 0; n < numbers_.size(); ++n) {
    lines.push_back(label(n) + ":");
    lines.push_back(fmt::format("{:<18} {:>5} {:>15} {:>12} {:>7}", "method", "level", "value", "error", "order"));
    for (std::size_t i = 0; i < levels_.size(); ++i) {
      lines.push_back(fmt::format("{:<18} {:>5} {:>15} {:>12} {:>7}", levels_[i].method, levels_[i].level,
                                  shown(levels_[i].values[n], "{:.8g}"), shown(error(i, n), "{:.4e}"),
                                  shown(order(i, n), "{:.2f}")));
      const bool is_last = !is_finer(i + 1, i);
      if (const std::string found = is_last && !scale_.has_reference ? limit(i, n) : ""; !found.empty()) {
        lines.push_back(found);
      }
    }
    if (scale_.has_reference) lines.push_back(fmt::format("the reference: {:.8g}", reference_[n]));
  }
  return lines;
}

std::string LevelResults::csv() const {
  std::string text = csv_header({"method", "level", "size", "result", "value", "error", "order"}) + "\n";
  for (std::size_t i = 0; i < levels_.size(); ++i) {
    for (std::size_t n = 0; n < numbers_.size(); ++n) {
      const std::array<double, 2> place{static_cast<double>(levels_[i].level), levels_[i].size};
      const std::array<double, 3> found{levels_[i].values[n], error(i, n), order(i, n)};
      text += csv_header({levels_[i].method}) + "," + csv_row(place) + "," + csv_header({numbers_[n].name}) + "," +
              csv_row(found) + "\n";
    }
  }
  return text;
}

std::optional<Plot> LevelResults::plot(std::size_t number, const std::string& title) const {
  Plot plot{title, scale_.label, "error of " + label(number), {}};
  bool has_points = false;
  for (std::size_t i = 0; i < levels_.size(); ++i) {
    if (plot.series.empty() || plot.series.back().name != levels_[i].method) {
      plot.series.push_back({levels_[i].method, {}, {}});
    }
    plot.series.back().x.push_back(levels_[i].size);
    plot.series.back().y.push_back(error(i, number));
    has_points = has_points || error(i, number) > 0.0;
  }
  return has_points ? std::optional(std::move(plot)) : std::nullopt;
}

std::vector<std::string> LevelResults::write(MPI_Comm comm, const std::filesystem::path& directory,
                                             const std::string& title) const {
  if (numbers_.empty()) return {};
  std::vector<std::string> files{(directory / "results.csv").string()};
  on_root(comm, [&] { write_text_atomically(files.front(), csv()); });
  for (std::size_t n = 0; n < numbers_.size(); ++n) {
    const auto drawn = plot(n, title.empty() ? "convergence" : title);
    if (!drawn) continue;
    files.push_back((directory / (file_name_of("error_" + numbers_[n].name) + ".svg")).string());
    write_svg(comm, files.back(), *drawn);
  }
  return files;
}

}  // namespace pliant
