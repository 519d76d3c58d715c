#include "study/fit_tables.hpp"

#include "base/text.hpp"
#include "input/tree.hpp"
#include "material/constants.hpp"
#include "material/viscosity.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <fmt/format.h>

namespace pliant {
namespace {

InputNode number_node(double value) {
  return InputNode::scalar(format_number(value));
}

InputNode elasticity_node(const FittedMaterial& fit) {
  const FitMaterialConfig& config = fit.config.material;
  std::vector<InputNode> entries{InputNode::scalar(config.model).under("model")};
  for (const auto& [key, value] : fit.material.constants(fit.all)) entries.push_back(number_node(value).under(key));
  if (config.volumetric != VolumetricForm::mixed) {
    const auto name = volumetric_form_names[static_cast<std::size_t>(config.volumetric)];
    entries.push_back(InputNode::scalar(std::string(name)).under("volumetric_energy"));
  }
  return InputNode::map(std::move(entries)).under("elasticity");
}

InputNode viscosity_node(const FittedMaterial& fit) {
  std::vector<InputNode> branches;
  for (std::size_t n = 0; n < fit.material.num_branches(); ++n) {
    std::vector<InputNode> entries{InputNode::scalar(std::string(Prony::name)).under("model")};
    entries.push_back(number_node(fit.material.ratio(fit.all, n)).under("ratio"));
    entries.push_back(number_node(fit.material.relaxation_time(fit.all, n)).under("relaxation_time"));
    branches.push_back(InputNode::map(std::move(entries)));
  }
  return InputNode::list(std::move(branches)).under("viscosity");
}

/// A number of a table; nothing where there is none.
std::string shown(double value) {
  return std::isnan(value) ? "" : fmt::format("{:.7g}", value);
}

}  // namespace

std::string fit_heading(const FittedMaterial& fit) {
  const std::size_t count = fit.residuals.size();
  const int terms = fit.config.material.terms.value_or(0);
  return fmt::format(
      "{}{}{}{}; {} test{}, {} measurements", fit.config.material.model,
      terms > 1 ? fmt::format(" with {} terms", terms) : "", fit.material.is_incompressible() ? ", incompressible" : "",
      fit.material.num_branches() > 0 ? fmt::format(", with {} Prony branches", fit.material.num_branches()) : "",
      fit.tests.size(), fit.tests.size() == 1 ? "" : "s", count);
}

std::string number_in_table(double value, int digits) {
  return std::isnan(value) ? "-" : fmt::format("{:.{}g}", value, digits);
}

std::string number_in_csv(double value) {
  return std::isnan(value) ? "" : std::isinf(value) ? "inf" : format_number(value);
}

double determination_of(double differences, double spread) {
  return spread > 0.0 ? 1.0 - differences / spread : std::numeric_limits<double>::quiet_NaN();
}

std::string determination_shown(double determination) {
  return std::isnan(determination) ? "-" : fmt::format("{:.5f}", determination);
}

std::optional<std::string> warning_about_determination(const std::string& name, double determination) {
  if (!(determination < 0.0)) return std::nullopt;
  return fmt::format(
      "{}: the fit is farther from the measurements than their mean is (R^2 = {:.2g}): check the columns and their "
      "units, the kind of the test and its loading, or take another model",
      name, determination);
}

std::vector<TestSummary> summaries_of(const FittedMaterial& fit) {
  std::vector<TestSummary> result;
  std::size_t next = 0;
  for (std::size_t n = 0; n < fit.tests.size() && n < fit.outcome.sums.size(); ++n) {
    const auto& y = fit.tests[n].y;
    const double mean = std::accumulate(y.begin(), y.end(), 0.0) / static_cast<double>(y.size());
    double spread = 0.0, differences = 0.0;
    for (std::size_t i = 0; i < y.size(); ++i, ++next) {
      const double size = fit.config.residual == ResidualKind::relative ? y[i] : 1.0;
      differences += std::pow(fit.residuals[next] * size, 2);
      spread += std::pow(y[i] - mean, 2);
    }
    const double sum = fit.outcome.sums[n];
    result.push_back({fit.tests[n].name, y.size(), sum, std::sqrt(sum / static_cast<double>(y.size())),
                      determination_of(differences, spread)});
  }
  return result;
}

std::vector<std::string> fit_tables(const FittedMaterial& fit) {
  std::vector<std::string> lines{fmt::format("{}: {}", fit.config.file, fit_heading(fit))};
  std::size_t width = 9;
  for (const FitParameter& p : fit.material.parameters()) width = std::max(width, p.name.size());
  lines.push_back(fmt::format("{:<{}}  {:>14}  {:>14}  unit", "parameter", width, "value", "standard error"));
  for (std::size_t n = 0; n < fit.all.size(); ++n) {
    const FitParameter& p = fit.material.parameters()[n];
    const auto place = fit.material.free_place(n);
    const bool has_error = place && *place < fit.outcome.standard_errors.size();
    const std::string error = !place      ? "held"
                              : has_error ? number_in_table(fit.outcome.standard_errors[*place], 3)
                                          : "";
    lines.push_back(
        fmt::format("{:<{}}  {:>14}  {:>14}  {}", p.name, width, shown(fit.all[n]), error, unit_shown(p.unit)));
  }
  if (fit.residuals.empty()) return lines;
  const bool is_relative = fit.config.residual == ResidualKind::relative;
  const char* unit = is_relative ? "" : " [Pa^2]";
  std::size_t name_width = 4;
  const auto summaries = summaries_of(fit);
  for (const TestSummary& test : summaries) name_width = std::max(name_width, test.name.size());
  lines.push_back(fmt::format("{:<{}}  {:>6}  {:>19}  {:>11}  {:>8}", "test", name_width, "points",
                              fmt::format("residual sum{}", unit), is_relative ? "rms" : "rms [Pa]", "R^2"));
  for (const TestSummary& test : summaries) {
    lines.push_back(fmt::format("{:<{}}  {:>6}  {:>19.7g}  {:>11.4g}  {:>8}", test.name, name_width, test.count,
                                test.sum, test.mean_square, determination_shown(test.determination)));
  }
  const auto rest = fit.material.law(fit.all).at_rest();
  if (rest && fit.material.is_incompressible()) {
    lines.push_back(fmt::format("at small strain: E = {:.4g} Pa, mu = {:.4g} Pa, nu = 0.5", 3.0 * rest->mu, rest->mu));
  } else if (rest) {
    lines.push_back("at small strain: " + equivalents(*rest));
  }
  if (fit.material.num_free() > 0) {
    lines.push_back(fmt::format("{} of {} starts led to this minimum; {} iterations", fit.outcome.num_best,
                                fit.outcome.num_starts, fit.outcome.minimum.num_iterations));
  }
  return lines;
}

std::string fit_csv(const FittedMaterial& fit) {
  std::string text = "parameter,value,standard_error,unit\n";
  for (const bool is_free : {true, false}) {
    for (std::size_t n = 0; n < fit.all.size(); ++n) {
      const FitParameter& p = fit.material.parameters()[n];
      if (p.is_free != is_free) continue;
      const auto place = fit.material.free_place(n);
      text += fmt::format("{},{},{},{}\n", p.name, format_number(fit.all[n]),
                          place ? number_in_csv(fit.outcome.standard_errors[*place]) : "", p.unit);
    }
  }
  return text;
}

std::string material_yaml(const FittedMaterial& fit) {
  std::vector<InputNode> body{elasticity_node(fit)};
  if (fit.material.num_branches() > 0) body.push_back(viscosity_node(fit));
  std::vector<InputNode> entries;
  if (fit.material.is_incompressible()) {
    entries.push_back(InputNode::scalar("P2").under("element"));
    entries.push_back(InputNode::scalar("mixed").under("volumetric"));
  }
  entries.push_back(InputNode::list({InputNode::map(std::move(body))}).under("bodies"));
  std::string text = fmt::format("# Fitted by `pliant fit {}`: {}.\n", fit.config.file, fit_heading(fit));
  for (const std::string& warning : fit.warnings) text += "# warning: " + warning + "\n";
  return text + to_yaml(InputNode::map(std::move(entries)));
}

}  // namespace pliant
