#include "study/fit_report.hpp"

#include "base/file.hpp"
#include "io/svg_plot.hpp"
#include "study/fit_page.hpp"
#include "study/fit_plots.hpp"
#include "study/fit_tables.hpp"

#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace pliant {
namespace {

std::vector<std::string> free_names(const FittedMaterial& fit) {
  std::vector<std::string> names;
  for (const std::size_t n : fit.material.free()) names.push_back(fit.material.parameters()[n].name);
  return names;
}

std::vector<ParameterOnPage> rows_of(const FittedMaterial& fit) {
  std::vector<ParameterOnPage> rows;
  for (std::size_t n = 0; n < fit.all.size(); ++n) {
    const FitParameter& p = fit.material.parameters()[n];
    const auto place = fit.material.free_place(n);
    rows.push_back(
        {p.name, fit.all[n], place ? std::optional(fit.outcome.standard_errors[*place]) : std::nullopt, p.unit});
  }
  return rows;
}

std::string tests(const FittedMaterial& fit) {
  const bool is_relative = fit.config.residual == ResidualKind::relative;
  HtmlTable table({"test", "points", "weight", is_relative ? "sum of squared relative residuals" : "residual sum [Pa²]",
                   is_relative ? "root mean square" : "root mean square [Pa]", "R²"});
  const auto summaries = summaries_of(fit);
  for (std::size_t n = 0; n < summaries.size(); ++n) {
    const TestSummary& test = summaries[n];
    table.add({test.name, std::to_string(test.count), number_on_page(fit.tests[n].config.weight),
               fmt::format("{:.7g}", test.sum), number_on_page(test.mean_square),
               determination_shown(test.determination)});
  }
  return part_of_page("Tests", "The differences between the law and the measurements.", table.text());
}

std::string stability(const FittedMaterial& fit) {
  HtmlTable table({"loading", "range", "measured", "finding"});
  for (const StabilityRange& range : fit.stability) {
    const std::string finding = fmt::format("{}", fmt::join(range.failures, "; "));
    table.add({std::string(loadings[static_cast<std::size_t>(range.loading)].name),
               fmt::format("{:.3g} to {:.3g}", range.lowest, range.highest), range.is_measured ? "yes" : "no",
               finding.empty() ? "stable" : finding});
  }
  return part_of_page(
      "Stability",
      "Whether the nominal stress rises with the stretch, whether Drucker's condition holds (every small "
      "further strain needs work), and whether the larger principal stress goes with the larger stretch "
      "(Baker-Ericksen). Loadings that were not measured are examined up to the same distortion "
      "(I<sub>1</sub>).",
      table.text());
}

}  // namespace

void write_report(const FittedMaterial& fit, const std::filesystem::path& directory) {
  const auto all = plots_of(fit);
  for (const NamedPlot& plot : all) {
    write_text_atomically(directory / (plot.name + ".svg"), svg(plot.plot), Durability::process);
  }
  const std::string title = fit.config.title.empty() ? "Fit of " + fit.config.material.model : fit.config.title;
  std::string page = start_of_page(
      title, fmt::format("{}. {} of {} starts led to this minimum; the fit has {}converged.", fit_heading(fit),
                         fit.outcome.num_best, fit.outcome.num_starts, fit.outcome.minimum.is_converged ? "" : "not "));
  page += messages_on_page(fit.warnings, fit.notes) + parameters_on_page(rows_of(fit)) + tests(fit);
  page += plots_on_page(all,
                        "Measurements (marks) and the fitted law (lines), and below the residuals: law minus "
                        "measurement. Residuals that follow a curve instead of scattering show that the law does not "
                        "have the shape of the data.");
  if (fit.material.num_free() > 0) {
    page += determination_on_page(free_names(fit), fit.outcome.determination) +
            correlations_on_page(free_names(fit), fit.outcome);
  }
  page += stability(fit);
  page += part_of_page("For an input", "Paste this into an input, and add a mesh and a density.",
                       text_on_page(material_yaml(fit)));
  write_text_atomically(directory / "report.html", page + end_of_page(), Durability::process);
}

}  // namespace pliant
