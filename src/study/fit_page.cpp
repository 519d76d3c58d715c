#include "study/fit_page.hpp"

#include "io/svg_plot.hpp"
#include "io/xdmf.hpp"

#include <cmath>

#include <fmt/format.h>

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

}  // namespace

void HtmlTable::add_row(const std::vector<std::string>& cells, const char* tag) {
  rows_ += "<tr>";
  for (const std::string& cell : cells) rows_ += fmt::format("<{0}>{1}</{0}>", tag, escaped(cell));
  rows_ += "</tr>\n";
}

std::string number_on_page(double value) {
  return std::isnan(value) ? "–" : std::isinf(value) ? "∞" : fmt::format("{:.4g}", value);
}

std::string part_of_page(const char* heading, const char* meaning, const std::string& content) {
  return fmt::format("<h2>{}</h2>\n<p>{}</p>\n{}", heading, meaning, content);
}

std::string start_of_page(const std::string& title, const std::string& summary) {
  std::string page = head;
  page.replace(page.find("{title}"), 7, escaped(title));
  return page + fmt::format("<h1>{}</h1>\n<p>{}</p>\n", escaped(title), escaped(summary));
}

std::string end_of_page() {
  return "</body>\n</html>\n";
}

std::string text_on_page(const std::string& text) {
  return "<pre>" + escaped(text) + "</pre>\n";
}

std::string parameters_on_page(const std::vector<ParameterOnPage>& rows) {
  HtmlTable table({"parameter", "value", "standard error", "relative", "unit"});
  for (const ParameterOnPage& p : rows) {
    const bool is_fitted = p.standard_error.has_value();
    table.add({p.name, fmt::format("{:.7g}", p.value), is_fitted ? number_on_page(*p.standard_error) : "held",
               is_fitted ? number_on_page(100.0 * *p.standard_error / std::abs(p.value)) + " %" : "",
               p.unit == "1" ? "" : p.unit});
  }
  return part_of_page("Parameters",
                      "A standard error is the scatter that the parameter would have if the test were repeated and the "
                      "residuals were random. It does not cover errors of the model.",
                      table.text());
}

std::string plots_on_page(const std::vector<NamedPlot>& all, const char* meaning) {
  // Each with names of its own for what its attributes refer to.
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
  return part_of_page("Curves", meaning, text);
}

std::string correlations_on_page(const std::vector<std::string>& names, const FitOutcome& outcome) {
  const std::size_t p = names.size();
  std::vector<std::string> header{""};
  header.insert(header.end(), names.begin(), names.end());
  HtmlTable correlation(header), covariance(header);
  for (std::size_t i = 0; i < p; ++i) {
    std::vector<std::string> row{names[i]}, other{names[i]};
    for (std::size_t j = 0; j < p; ++j) {
      const double value = outcome.correlation[p * i + j];
      row.push_back(std::isfinite(value) ? fmt::format("{:.3f}", value) : "–");
      other.push_back(number_on_page(outcome.determination.covariance[p * i + j]));
    }
    correlation.add(row);
    covariance.add(other);
  }
  return part_of_page(
             "Correlation",
             "Near 1 or -1: the data determine a combination of the two parameters well, but hardly each of them.",
             correlation.text()) +
         part_of_page("Covariance", "In the products of the parameters' SI units.", covariance.text());
}

std::string determination_on_page(const std::vector<std::string>& names, const Determination& known) {
  HtmlTable table({"direction of relative change", "singular value", "relative to the largest"});
  for (std::size_t k = 0; k < known.singular_values.size(); ++k) {
    std::string direction;
    for (std::size_t j = 0; j < names.size(); ++j) {
      if (std::abs(known.modes[k][j]) < 0.05) continue;
      direction += fmt::format("{}{:.2f} {}", direction.empty() ? "" : ", ", known.modes[k][j], names[j]);
    }
    table.add({direction, number_on_page(known.singular_values[k]),
               number_on_page(known.singular_values[k] / known.singular_values.front())});
  }
  std::string text = table.text();
  for (std::size_t j = 0; j < names.size(); ++j) {
    if (known.is_at_bound[j]) text += "<p>At a bound: " + escaped(names[j]) + "</p>\n";
    if (!known.is_determined[j]) text += "<p>Not determined by the data: " + escaped(names[j]) + "</p>\n";
  }
  return part_of_page(
      "What the data determine",
      "Singular values of the sensitivity of all residuals to relative changes of the parameters. A change in "
      "a direction with a small value hardly shows in the tests; below 1e-8 of the largest, not at all.",
      text);
}

std::string messages_on_page(const std::vector<std::string>& warnings, const std::vector<std::string>& notes) {
  std::string text;
  for (const std::string& warning : warnings) text += "<p class=\"warning\">" + escaped(warning) + "</p>\n";
  for (const std::string& note : notes) text += "<p class=\"note\">" + escaped(note) + "</p>\n";
  return text;
}

}  // namespace pliant
