#include "study/fit_plots.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

namespace pliant {
namespace {

/// A unit in which a stress is a handy number.
struct StressUnit {
  const char* name;
  double size;  ///< [Pa]
};

StressUnit unit_for(double largest) {
  constexpr std::array<StressUnit, 4> units{{{"GPa", 1e9}, {"MPa", 1e6}, {"kPa", 1e3}, {"Pa", 1.0}}};
  const auto* const found = std::ranges::find_if(units, [&](const StressUnit& unit) { return largest >= unit.size; });
  return found == units.end() ? units.back() : *found;
}

double largest_of(const std::vector<double>& values) {
  double largest = 0.0;
  for (const double value : values) largest = std::max(largest, std::abs(value));
  return largest;
}

bool spans_decades(const std::vector<double>& x) {
  const auto [low, high] = std::ranges::minmax(x);
  return low > 0.0 && high > 100.0 * low;
}

std::string with_unit(std::string_view label, const StressUnit& unit) {
  return std::string(label.substr(0, label.find(" ["))) + " [" + unit.name + "]";
}

/// Places for a smooth curve: from rest through the measured range of an elastic test, else through the range alone.
std::vector<double> curve_places(const MaterialTest& test) {
  constexpr int count = 200;
  auto [low, high] = std::ranges::minmax(test.x);
  if (test.is_elastic()) low = std::min(low, 1.0), high = std::max(high, 1.0);
  const bool is_log = !test.is_elastic() && spans_decades(test.x);
  std::vector<double> places;
  for (int n = 0; n <= count; ++n) {
    const double part = static_cast<double>(n) / count;
    places.push_back(is_log ? low * std::pow(high / low, part) : low + (high - low) * part);
  }
  return places;
}

std::size_t channels(const MaterialTest& test) {
  return test.y.size() / test.x.size();
}

/// One of the curves of a test: every so many values.
std::vector<double> channel(const std::vector<double>& values, std::size_t which, std::size_t count, double scale) {
  std::vector<double> result;
  for (std::size_t n = which; n < values.size(); n += count) result.push_back(values[n] * scale);
  return result;
}

std::vector<double> predicted_values(const FittedMaterial& fit, const MaterialTest& test,
                                     const std::vector<double>& places) {
  std::vector<double> values;
  for (const Sensitive& one : test.predicted(fit.material, fit.all, places)) values.push_back(one.value);
  return values;
}

/// Adds the measurements and the fitted curve of a test in a common colour.
void add_curves(const FittedMaterial& fit, const MaterialTest& test, const std::string& label, const StressUnit& unit,
                Plot& plot) {
  const auto places = curve_places(test);
  const auto curve = predicted_values(fit, test, places);
  constexpr std::array parts{"storage", "loss"};
  for (std::size_t k = 0; k < channels(test); ++k) {
    const std::string name =
        channels(test) > 1 ? fmt::format("{}{}", label.empty() ? "" : label + " ", parts[k]) : label;
    const std::size_t colour = plot.series.size() / 2;
    plot.series.push_back({name.empty() ? "measured" : name + ", measured", test.x,
                           channel(test.y, k, channels(test), 1.0 / unit.size), SeriesStyle::marks, colour});
    plot.series.push_back({name.empty() ? "fitted" : name + ", fitted", places,
                           channel(curve, k, channels(test), 1.0 / unit.size), SeriesStyle::line, colour});
  }
}

Plot plot_of(const FittedMaterial& fit, const MaterialTest& test) {
  const TestKindInfo& info = test_kinds()[static_cast<std::size_t>(test.config.kind)];
  const StressUnit unit = unit_for(largest_of(test.y));
  Plot plot{test.name, std::string(info.abscissa), with_unit(info.ordinate, unit), {}};
  plot.scale = test.config.kind == TestKind::dma ? Scale::logarithmic : Scale::linear;
  if (test.config.kind == TestKind::relaxation && spans_decades(test.x)) plot.x_scale = Scale::logarithmic;
  add_curves(fit, test, "", unit, plot);
  return plot;
}

Plot residual_plot(const FittedMaterial& fit, const MaterialTest& test, std::vector<double> residuals) {
  const TestKindInfo& info = test_kinds()[static_cast<std::size_t>(test.config.kind)];
  const bool is_relative = fit.config.residual == ResidualKind::relative;
  const StressUnit unit = is_relative ? StressUnit{"%", 0.01} : unit_for(largest_of(residuals));
  Plot plot{test.name + ": residuals",
            std::string(info.abscissa),
            is_relative ? "relative residual [%]" : fmt::format("residual [{}]", unit.name),
            {}};
  plot.scale = Scale::linear;
  if (!test.is_elastic() && spans_decades(test.x)) plot.x_scale = Scale::logarithmic;
  const auto [low, high] = std::ranges::minmax(test.x);
  constexpr std::array parts{"storage", "loss"};
  for (std::size_t k = 0; k < channels(test); ++k) {
    plot.series.push_back({channels(test) > 1 ? parts[k] : "fitted - measured", test.x,
                           channel(residuals, k, channels(test), 1.0 / unit.size), SeriesStyle::marks});
  }
  plot.series.push_back({"0", {low, high}, {0.0, 0.0}, SeriesStyle::line, 7});
  return plot;
}

}  // namespace

std::vector<NamedPlot> plots_of(const FittedMaterial& fit) {
  std::vector<NamedPlot> plots;
  std::vector<const MaterialTest*> stretched;
  std::vector<double> stresses;
  for (const MaterialTest& test : fit.tests) {
    if (!test.is_elastic() || test.config.kind == TestKind::volumetric) continue;
    stretched.push_back(&test);
    stresses.insert(stresses.end(), test.y.begin(), test.y.end());
  }
  if (stretched.size() > 1) {
    const StressUnit unit = unit_for(largest_of(stresses));
    const bool has_shear = std::ranges::any_of(
        stretched, [](const MaterialTest* test) { return test->config.kind == TestKind::simple_shear; });
    Plot plot{"all tests",
              has_shear ? "stretch; 1 + amount of shear" : "stretch",
              fmt::format("nominal stress [{}]", unit.name),
              {}};
    plot.scale = Scale::linear;
    for (const MaterialTest* test : stretched) {
      add_curves(fit, *test, std::string(test_kinds()[static_cast<std::size_t>(test->config.kind)].name), unit, plot);
    }
    plots.push_back({"all_tests", std::move(plot)});
  }
  auto next = fit.residuals.begin();
  for (std::size_t n = 0; n < fit.tests.size(); ++n) {
    const MaterialTest& test = fit.tests[n];
    const auto& kind = test_kinds()[static_cast<std::size_t>(test.config.kind)].name;
    const std::string name = fmt::format("{}_{}", n + 1, kind);
    const auto end = next + static_cast<std::ptrdiff_t>(test.y.size());
    plots.push_back({name, plot_of(fit, test)});
    plots.push_back({name + "_residuals", residual_plot(fit, test, {next, end})});
    next = end;
  }
  return plots;
}

}  // namespace pliant
