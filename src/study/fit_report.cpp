#include "study/fit_report.hpp"

#include "base/file.hpp"
#include "io/svg_plot.hpp"
#include "io/xdmf.hpp"
#include "study/fit_plots.hpp"
#include "study/fit_tables.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace pliant {
namespace {

constexpr const char* head = R"(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>
body { font-family: "DejaVu Sans", Verdana, Arial, sans-serif; font-size: 15px; line-height: 1.5; color: #2d3139;
  max-width: 1000px; margin: 2em auto; padding: 0 1em; }
h1 { font-size: 24px; } h2 { font-size: 18px; margin-top: 2em; }
table { border-collapse: collapse; margin: 1em 0; }
th, td { padding: 4px 14px 4px 0; text-align: right; border-bottom: 1px solid #d5d9df; font-variant-numeric: tabular-nums; }
th:first-child, td:first-child, td.words { text-align: left; }
th { color: #5a606b; font-weight: normal; }
pre { background: #f4f5f7; padding: 1em; overflow-x: auto; }
p.warning { background: #fdf1ea; border-left: 4px solid #d1603d; padding: 6px 12px; margin: 6px 0; }
p.note { background: #f4f5f7; border-left: 4px solid #8b919b; padding: 6px 12px; margin: 6px 0; }
svg { max-width: 100%; height: auto; }
</style>
</head>
<body>
)";

std::string escaped(const std::string& text) {
  return xml_escaped(text);
}

/// A table whose cells are escaped; those of the first column are words.
class HtmlTable {
 public:
  explicit HtmlTable(const std::vector<std::string>& header) { add_row(header, "th"); }
  void add(const std::vector<std::string>& cells) { add_row(cells, "td"); }
  std::string text() const { return "<table>\n" + rows_ + "</table>\n"; }

 private:
  void add_row(const std::vector<std::string>& cells, const char* tag) {
    rows_ += "<tr>";
    for (const std::string& cell : cells) rows_ += fmt::format("<{0}>{1}</{0}>", tag, escaped(cell));
    rows_ += "</tr>\n";
  }
  std::string rows_;
};

std::string number(double value) {
  return std::isnan(value) ? "–" : std::isinf(value) ? "∞" : fmt::format("{:.4g}", value);
}

/// A part of the page: a heading, what it means, and what belongs there.
std::string part(const char* heading, const char* meaning, const std::string& content) {
  return fmt::format("<h2>{}</h2>\n<p>{}</p>\n{}", heading, meaning, content);
}

std::vector<std::string> free_names(const FittedMaterial& fit) {
  std::vector<std::string> names;
  for (const std::size_t n : fit.material.free()) names.push_back(fit.material.parameters()[n].name);
  return names;
}

std::string parameters(const FittedMaterial& fit) {
  HtmlTable table({"parameter", "value", "standard error", "relative", "unit"});
  for (std::size_t n = 0; n < fit.all.size(); ++n) {
    const FitParameter& p = fit.material.parameters()[n];
    const auto place = fit.material.free_place(n);
    const double error = place ? fit.outcome.standard_errors[*place] : 0.0;
    table.add({p.name, fmt::format("{:.7g}", fit.all[n]), place ? number(error) : "held",
               place ? number(100.0 * error / std::abs(fit.all[n])) + " %" : "", p.unit == "1" ? "" : p.unit});
  }
  return part("Parameters",
              "A standard error is the scatter that the parameter would have if the test were repeated and the "
              "residuals were random. It does not cover errors of the law.",
              table.text());
}

std::string tests(const FittedMaterial& fit) {
  const bool is_relative = fit.config.residual == ResidualKind::relative;
  HtmlTable table({"test", "points", "weight", is_relative ? "sum of squared relative residuals" : "residual sum [Pa²]",
                   is_relative ? "root mean square" : "root mean square [Pa]", "R²"});
  const auto summaries = summaries_of(fit);
  for (std::size_t n = 0; n < summaries.size(); ++n) {
    const TestSummary& test = summaries[n];
    table.add({test.name, std::to_string(test.count), number(fit.tests[n].config.weight),
               fmt::format("{:.7g}", test.sum), number(test.mean_square), fmt::format("{:.5f}", test.determination)});
  }
  return part("Tests", "The differences between the law and the measurements.", table.text());
}

/// The plots within the page: each with names of its own for what its attributes refer to.
std::string plots(const std::vector<NamedPlot>& all) {
  std::string text;
  for (std::size_t n = 0; n < all.size(); ++n) {
    std::string picture = svg(all[n].plot);
    picture.erase(0, picture.find("<svg"));
    for (const std::string name : {"title", "description"}) {
      for (const std::string& use : {"id=\"" + name + "\"", "labelledby=\"" + name, " " + name + "\""}) {
        const std::size_t at = picture.find(use);
        if (at != std::string::npos) picture.replace(at + use.find(name), name.size(), fmt::format("{}-{}", name, n));
      }
    }
    text += picture;
  }
  return part("Curves",
              "Measurements (marks) and the fitted law (lines), and below the residuals: law minus "
              "measurement. Residuals that follow a curve instead of scattering show that the law does not have the "
              "shape of the data.",
              text);
}

std::string correlations(const FittedMaterial& fit) {
  const auto names = free_names(fit);
  const std::size_t p = names.size();
  std::vector<std::string> header{""};
  header.insert(header.end(), names.begin(), names.end());
  HtmlTable correlation(header), covariance(header);
  for (std::size_t i = 0; i < p; ++i) {
    std::vector<std::string> row{names[i]}, other{names[i]};
    for (std::size_t j = 0; j < p; ++j) {
      const double value = fit.outcome.correlation[p * i + j];
      row.push_back(std::isfinite(value) ? fmt::format("{:.3f}", value) : "–");
      other.push_back(number(fit.outcome.determination.covariance[p * i + j]));
    }
    correlation.add(row);
    covariance.add(other);
  }
  return part("Correlation",
              "Near 1 or -1: the data determine a combination of the two parameters well, but hardly each of them.",
              correlation.text()) +
         part("Covariance", "In the products of the parameters' SI units.", covariance.text());
}

std::string determined(const FittedMaterial& fit) {
  const Determination& known = fit.outcome.determination;
  const auto names = free_names(fit);
  HtmlTable table({"direction of relative change", "singular value", "relative to the largest"});
  for (std::size_t k = 0; k < known.singular_values.size(); ++k) {
    std::string direction;
    for (std::size_t j = 0; j < names.size(); ++j) {
      if (std::abs(known.modes[k][j]) < 0.05) continue;
      direction += fmt::format("{}{:.2f} {}", direction.empty() ? "" : ", ", known.modes[k][j], names[j]);
    }
    table.add({direction, number(known.singular_values[k]),
               number(known.singular_values[k] / known.singular_values.front())});
  }
  std::string text = table.text();
  for (std::size_t j = 0; j < names.size(); ++j) {
    if (known.is_at_bound[j]) text += "<p>At a bound: " + escaped(names[j]) + "</p>\n";
    if (!known.is_determined[j]) text += "<p>Not determined by the data: " + escaped(names[j]) + "</p>\n";
  }
  return part("What the data determine",
              "Singular values of the sensitivity of all residuals to relative changes of the parameters. A change in "
              "a direction with a small value hardly shows in the tests; below 1e-8 of the largest, not at all.",
              text);
}

std::string stability(const FittedMaterial& fit) {
  HtmlTable table({"loading", "range", "measured", "finding"});
  for (const StabilityRange& range : fit.stability) {
    const std::string finding = fmt::format("{}", fmt::join(range.failures, "; "));
    table.add({std::string(loadings[static_cast<std::size_t>(range.loading)].name),
               fmt::format("{:.3g} to {:.3g}", range.lowest, range.highest), range.is_measured ? "yes" : "no",
               finding.empty() ? "stable" : finding});
  }
  return part("Stability",
              "Whether the nominal stress rises with the stretch, whether Drucker's condition holds (every small "
              "further strain needs work), and whether the larger principal stress goes with the larger stretch "
              "(Baker-Ericksen). Loadings that were not measured are examined up to the same distortion "
              "(I<sub>1</sub>).",
              table.text());
}

std::string messages(const FittedMaterial& fit) {
  std::string text;
  for (const std::string& warning : fit.warnings) text += "<p class=\"warning\">" + escaped(warning) + "</p>\n";
  for (const std::string& note : fit.notes) text += "<p class=\"note\">" + escaped(note) + "</p>\n";
  return text;
}

}  // namespace

void write_report(const FittedMaterial& fit, const std::filesystem::path& directory) {
  const auto all = plots_of(fit);
  for (const NamedPlot& plot : all) {
    write_text_atomically(directory / (plot.name + ".svg"), svg(plot.plot), Durability::process);
  }
  const std::string title = fit.config.title.empty() ? "Fit of " + fit.config.material.model : fit.config.title;
  std::string page = head;
  page.replace(page.find("{title}"), 7, escaped(title));
  page += fmt::format("<h1>{}</h1>\n<p>{}. {} of {} starts led to this minimum; the fit has {}converged.</p>\n",
                      escaped(title), escaped(fit_heading(fit)), fit.outcome.num_best, fit.outcome.num_starts,
                      fit.outcome.minimum.is_converged ? "" : "not ");
  page += messages(fit) + parameters(fit) + tests(fit) + plots(all);
  if (fit.material.num_free() > 0) page += determined(fit) + correlations(fit);
  page += stability(fit);
  page += part("For an input", "Paste this into an input, and add a mesh and a density.",
               "<pre>" + escaped(material_yaml(fit)) + "</pre>\n");
  write_text_atomically(directory / "report.html", page + "</body>\n</html>\n", Durability::process);
}

}  // namespace pliant
