#include "study/fit_run_report.hpp"

#include "base/file.hpp"
#include "base/text.hpp"
#include "study/fit_page.hpp"
#include "study/fit_tables.hpp"
#include "study/labelled_history.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

namespace pliant {
namespace {

std::string with_unit(const std::string& name, const std::string& unit) {
  return unit == "1" ? name : fmt::format("{} [{}]", name, unit);
}

/// Root mean square of a target's residuals, in SI.
double rms(const FittedRun& fit, std::size_t n) {
  const FitTarget& target = fit.targets[n];
  return target.scale * std::sqrt(fit.outcome.sums[n] / static_cast<double>(target.values.size()));
}

std::vector<std::string> notes_of(const FittedRun& fit) {
  std::vector<std::string> notes;
  for (const FitTarget& target : fit.targets) {
    if (!target.note.empty()) notes.push_back(target.note);
  }
  return notes;
}

std::string heading(const FittedRun& fit) {
  return fmt::format("{} number{} of {}, {} target{}, {} measurements", fit.numbers.size(),
                     fit.numbers.size() == 1 ? "" : "s", fit.config.input->value, fit.targets.size(),
                     fit.targets.size() == 1 ? "" : "s", fit.residuals.size());
}

std::string csv(const FittedRun& fit) {
  std::string text = "parameter,value,standard_error,unit\n";
  for (std::size_t j = 0; j < fit.numbers.size(); ++j) {
    text += fmt::format("{},{},{},{}\n", fit.numbers[j].key, format_number(fit.outcome.values[j]),
                        number_in_csv(fit.outcome.standard_errors[j]), fit.numbers[j].unit);
  }
  return text;
}

std::string yaml(const FittedRun& fit) {
  std::string text = fmt::format("# Fitted by `pliant fit {}`: {}.\n", fit.config.file, heading(fit));
  for (std::size_t j = 0; j < fit.numbers.size(); ++j) {
    text += fmt::format("# {} = {}\n", fit.numbers[j].key, format_number(fit.outcome.values[j]));
  }
  for (const std::string& warning : fit.warnings) text += "# warning: " + warning + "\n";
  return text + fit.input;
}

std::vector<NamedPlot> plots_of(const FittedRun& fit) {
  std::vector<NamedPlot> plots;
  const std::string instants = axis_label(abscissa_of(fit.input));
  auto next = fit.residuals.begin();
  for (std::size_t n = 0; n < fit.targets.size(); ++n) {
    const FitTarget& target = fit.targets[n];
    const auto end = next + static_cast<std::ptrdiff_t>(target.values.size());
    std::vector<double> residuals(next, end);
    for (double& r : residuals) r *= target.scale;
    next = end;
    const std::string name = fmt::format("{}_{}", n + 1, target.config.column);
    Plot curves{target.name, instants, with_unit(target.config.column, target.unit), {}};
    curves.scale = Scale::linear;
    curves.series = {{"measured", target.times, target.values, SeriesStyle::marks, 0},
                     {"fitted", target.times, target.fitted, SeriesStyle::line, 1}};
    Plot rest{target.name + ": residuals", instants, with_unit("residual", target.unit), {}};
    rest.scale = Scale::linear;
    const auto [low, high] = std::ranges::minmax(target.times);
    rest.series = {{"fitted - measured", target.times, residuals, SeriesStyle::marks},
                   {"0", {low, high}, {0.0, 0.0}, SeriesStyle::line, 7}};
    plots.push_back({name, std::move(curves)});
    plots.push_back({name + "_residuals", std::move(rest)});
  }
  return plots;
}

std::string targets_on_page(const FittedRun& fit) {
  HtmlTable table({"target", "points", "weight", "scale", "root mean square", "unit", "R²"});
  for (std::size_t n = 0; n < fit.targets.size(); ++n) {
    const FitTarget& target = fit.targets[n];
    table.add({target.name, std::to_string(target.values.size()), number_on_page(target.config.weight),
               number_on_page(target.scale), number_on_page(rms(fit, n)), unit_shown(target.unit),
               determination_shown(determination_of(fit, n))});
  }
  return part_of_page("Targets",
                      "The differences between the run and the measurements. Residuals are divided by the scale before "
                      "their squares are added.",
                      table.text());
}

}  // namespace

double determination_of(const FittedRun& fit, std::size_t n) {
  const FitTarget& target = fit.targets[n];
  const auto count = static_cast<double>(target.values.size());
  const double mean = std::accumulate(target.values.begin(), target.values.end(), 0.0) / count;
  double spread = 0.0;
  for (const double value : target.values) spread += std::pow(value - mean, 2);
  return determination_of(fit.outcome.sums[n] * target.scale * target.scale, spread);
}

std::vector<std::string> fit_tables(const FittedRun& fit) {
  std::vector<std::string> lines{fmt::format("{}: {}", fit.config.file, heading(fit))};
  std::size_t width = 9, name_width = 6;
  for (const VariedNumber& p : fit.numbers) width = std::max(width, p.key.size());
  for (const FitTarget& target : fit.targets) name_width = std::max(name_width, target.name.size());
  lines.push_back(fmt::format("{:<{}}  {:>14}  {:>14}  unit", "parameter", width, "value", "standard error"));
  for (std::size_t j = 0; j < fit.numbers.size(); ++j) {
    lines.push_back(fmt::format("{:<{}}  {:>14.7g}  {:>14}  {}", fit.numbers[j].key, width, fit.outcome.values[j],
                                number_in_table(fit.outcome.standard_errors[j], 3), unit_shown(fit.numbers[j].unit)));
  }
  lines.push_back(
      fmt::format("{:<{}}  {:>6}  {:>12}  {:<6}  {:>8}", "target", name_width, "points", "rms", "unit", "R^2"));
  for (std::size_t n = 0; n < fit.targets.size(); ++n) {
    const FitTarget& target = fit.targets[n];
    lines.push_back(fmt::format("{:<{}}  {:>6}  {:>12.4g}  {:<6}  {:>8}", target.name, name_width, target.values.size(),
                                rms(fit, n), unit_shown(target.unit), determination_shown(determination_of(fit, n))));
  }
  lines.push_back(fmt::format("{} of {} starts led to this minimum; {} runs", fit.outcome.num_best,
                              fit.outcome.num_starts, fit.num_runs));
  return lines;
}

void write_fit(const FittedRun& fit, const std::filesystem::path& directory) {
  make_directory(directory);
  write_text_atomically(directory / "fit.csv", csv(fit));
  write_text_atomically(directory / "fitted.yaml", yaml(fit));
  const auto plots = plots_of(fit);
  for (const NamedPlot& plot : plots) {
    write_text_atomically(directory / (plot.name + ".svg"), svg(plot.plot), Durability::process);
  }
  const FitOutcome& outcome = fit.outcome;
  std::vector<std::string> names;
  std::vector<ParameterOnPage> rows;
  std::string settings;
  for (std::size_t j = 0; j < fit.numbers.size(); ++j) {
    const VariedNumber& p = fit.numbers[j];
    names.push_back(p.key);
    rows.push_back({p.key, outcome.values[j], outcome.standard_errors[j], p.unit});
    settings += fmt::format("{} --set {}={}", j == 0 ? "pliant run " + fit.config.input->value : "", p.key,
                            format_number(outcome.values[j]));
  }
  std::string page = start_of_page(
      fit.config.title.empty() ? "Fit of " + fit.config.input->value : fit.config.title,
      fmt::format("{}. {} of {} starts led to this minimum, in {} runs; the fit has {}converged.", heading(fit),
                  outcome.num_best, outcome.num_starts, fit.num_runs, outcome.minimum.is_converged ? "" : "not "));
  page += messages_on_page(fit.warnings, notes_of(fit)) + parameters_on_page(rows) + targets_on_page(fit);
  page += plots_on_page(plots,
                        "Measurements (marks) and the fitted motion (lines), and below the residuals: run minus "
                        "measurement. Residuals that follow a curve instead of scattering show what the model lacks.");
  page += determination_on_page(names, outcome.determination) + correlations_on_page(names, outcome);
  page += part_of_page("The fitted run", "The input with these values is fitted.yaml; or:", text_on_page(settings));
  write_text_atomically(directory / "report.html", page + end_of_page(), Durability::process);
}

}  // namespace pliant
