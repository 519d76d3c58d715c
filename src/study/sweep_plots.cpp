#include "study/sweep_plots.hpp"

#include "base/file.hpp"
#include "base/limits.hpp"
#include "base/text.hpp"
#include "base/units.hpp"
#include "io/svg_map.hpp"
#include "io/svg_plot.hpp"
#include "study/history_plots.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace pliant {
namespace {

/// The values of a key as numbers of one unit, run by run.
struct SweptNumbers {
  std::size_t key;
  std::vector<double> values;
  std::string unit;

  std::size_t num_distinct() const { return std::set<double>(values.begin(), values.end()).size(); }

  std::string label(const std::vector<SweptValues>& keys) const {
    return unit.empty() ? keys[key].name : fmt::format("{} [{}]", keys[key].name, unit);
  }

  /// What the user wants; or else, for values of a list, logarithmic where they are positive and their factors are more
  /// alike than their steps.
  Scale scale(const std::vector<SweptValues>& keys) const {
    if (keys[key].scale || keys[key].is_sampled) return keys[key].scale.value_or(Scale::linear);
    const std::set<double> distinct(values.begin(), values.end());
    if (distinct.size() < 2 || *distinct.begin() <= 0.0) return Scale::linear;
    double least_step = infinity, largest_step = 0.0, least_factor = infinity, largest_factor = 0.0;
    for (auto a = distinct.begin(), b = std::next(a); b != distinct.end(); a = b++) {
      least_step = std::min(least_step, *b - *a);
      largest_step = std::max(largest_step, *b - *a);
      least_factor = std::min(least_factor, std::log(*b / *a));
      largest_factor = std::max(largest_factor, std::log(*b / *a));
    }
    const bool has_like_factors = largest_factor / least_factor < largest_step / least_step;
    return has_like_factors ? Scale::logarithmic : Scale::linear;
  }
};

/// As typed, if all have the same unit; otherwise in SI. Nothing if they are not all numbers.
std::optional<SweptNumbers> numbers_of(const std::vector<SweptValues>& keys, std::size_t key) {
  SweptNumbers numbers{key, {}, ""};
  for (const std::string& text : keys[key].texts) {
    const std::size_t end = std::min(text.find(' '), text.size());
    const auto number = parse_number(std::string_view(text).substr(0, end));
    std::string unit(trimmed(std::string_view(text).substr(end)));
    if (unit.empty()) unit = keys[key].unit;
    if (!number || (!numbers.values.empty() && numbers.unit != unit)) {
      auto in_si = si_values(keys[key]);
      if (!in_si) return std::nullopt;
      return SweptNumbers{key, std::move(*in_si), keys[key].unit};
    }
    numbers.unit = unit;
    numbers.values.push_back(*number);
  }
  return numbers;
}

std::string label_of(const SweptResult& result) {
  return result.unit.empty() ? result.name : fmt::format("{} [{}]", result.name, result.unit);
}

void write(const std::filesystem::path& directory, const std::string& name, const std::string& picture) {
  write_text_atomically(directory / (file_name_of(name) + ".svg"), picture);
}

/// One curve for each choice of the keys that are not in `except`.
Plot plot_over(const SweptNumbers& numbers, const std::vector<SweptValues>& keys, const SweptResult& result,
               const std::vector<std::size_t>& except) {
  Plot plot{result.name, numbers.label(keys), label_of(result), {}};
  plot.scale = Scale::linear;
  const bool is_sampled = keys[numbers.key].is_sampled;
  if (is_sampled) plot.x_scale = numbers.scale(keys);
  for (std::size_t run = 0; run < result.values.size(); ++run) {
    std::string name = label_of(keys, run, except);
    if (name.empty()) name = result.name;
    auto series = std::ranges::find(plot.series, name, &PlotSeries::name);
    if (series == plot.series.end()) {
      const auto style = is_sampled ? SeriesStyle::marks : SeriesStyle::line_with_marks;
      series = plot.series.insert(series, {name, {}, {}, style});
    }
    series->x.push_back(numbers.values[run]);
    series->y.push_back(result.values[run]);
  }
  return plot;
}

/// A map for each choice of the keys other than the two.
std::size_t draw_maps(const SweptNumbers& x, const SweptNumbers& y, const std::vector<SweptValues>& keys,
                      const SweptResult& result, const std::filesystem::path& directory) {
  std::vector<std::pair<std::string, ValueMap>> maps;
  for (std::size_t run = 0; run < result.values.size(); ++run) {
    const std::string others = label_of(keys, run, {x.key, y.key});
    auto found = std::ranges::find(maps, others, &std::pair<std::string, ValueMap>::first);
    if (found == maps.end()) {
      const std::string title = others.empty() ? result.name : result.name + ", " + others;
      found = maps.insert(
          found,
          {others, {title, x.label(keys), y.label(keys), label_of(result), {}, {}, {}, x.scale(keys), y.scale(keys)}});
    }
    found->second.x.push_back(x.values[run]);
    found->second.y.push_back(y.values[run]);
    found->second.values.push_back(result.values[run]);
  }
  for (const auto& [others, map] : maps) {
    write(directory, result.name + "_map" + (others.empty() ? "" : "," + others), svg_map(map));
  }
  return maps.size();
}

}  // namespace

std::string label_of(const std::vector<SweptValues>& keys, std::size_t run, const std::vector<std::size_t>& except) {
  std::vector<std::string> parts;
  for (std::size_t k = 0; k < keys.size(); ++k) {
    if (std::ranges::find(except, k) == except.end()) parts.push_back(keys[k].name + "=" + keys[k].texts[run]);
  }
  return fmt::format("{}", fmt::join(parts, ","));
}

std::optional<std::vector<double>> si_values(const SweptValues& values) {
  std::vector<double> numbers;
  for (const std::string& text : values.texts) {
    try {
      numbers.push_back(parse_quantity(text, values.unit.empty() ? "1" : values.unit));
    } catch (const UnitError&) {
      return std::nullopt;
    }
  }
  return numbers;
}

std::size_t draw_result(const std::vector<SweptValues>& keys, const SweptResult& result,
                        const std::filesystem::path& directory) {
  std::vector<SweptNumbers> all;
  std::vector<std::size_t> sampled;
  for (std::size_t k = 0; k < keys.size(); ++k) {
    auto numbers = numbers_of(keys, k);
    if (numbers) all.push_back(std::move(*numbers));
    if (keys[k].is_sampled) sampled.push_back(k);
  }
  if (all.empty()) return 0;
  std::size_t count = 0;
  for (const SweptNumbers& numbers : all) {
    if (!keys[numbers.key].is_sampled) continue;
    write(directory, result.name + "_over_" + keys[numbers.key].name, svg(plot_over(numbers, keys, result, sampled)));
    ++count;
  }
  if (count == 0) {
    const SweptNumbers& most = *std::ranges::max_element(all, {}, &SweptNumbers::num_distinct);
    write(directory, result.name, svg(plot_over(most, keys, result, {most.key})));
    count = 1;
  }
  std::erase_if(all, [](const SweptNumbers& numbers) { return numbers.num_distinct() < 2; });
  return count + (all.size() == 2 ? draw_maps(all[0], all[1], keys, result, directory) : 0);
}

}  // namespace pliant
