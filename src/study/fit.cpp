#include "study/fit.hpp"

#include "base/file.hpp"
#include "base/text.hpp"
#include "petsc/collective.hpp"
#include "study/fit_input.hpp"
#include "study/fit_report.hpp"
#include "study/fit_run.hpp"
#include "study/fit_starts.hpp"
#include "study/fit_tables.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace pliant {
namespace {

namespace fs = std::filesystem;

std::string text_of_fit(const std::string& file) {
  std::error_code ignored;
  std::ifstream stream(file, std::ios::binary);
  if (!stream || fs::is_directory(file, ignored)) {
    throw InputError({file, 0, 0}, "cannot read it; give the path of a fit file (YAML)");
  }
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::vector<MaterialTest> read_tests(const FitConfig& config) {
  std::vector<MaterialTest> tests;
  std::vector<Diagnostic> errors;
  for (const FitTestConfig& test : config.tests) {
    try {
      tests.push_back(read_test(test, fs::path(config.file).parent_path().string()));
      const bool has_zero = std::ranges::find(tests.back().y, 0.0) != tests.back().y.end();
      if (config.residual == ResidualKind::relative && has_zero) {
        throw InputError(test.data.where,
                         "the table has the value 0, to which no residual is relative; delete the row, "
                         "or choose 'residual: absolute'");
      }
    } catch (const InputError& error) {
      errors.insert(errors.end(), error.diagnostics().begin(), error.diagnostics().end());
    }
  }
  if (!errors.empty()) throw InputError(std::move(errors));
  return tests;
}

/// An unknown on which no test depends would make a fit of nothing.
void check_viscosity_is_tested(const FitConfig& config) {
  const auto shows_viscosity = [](const FitTestConfig& test) {
    return test.kind == TestKind::relaxation || test.kind == TestKind::dma;
  };
  if (!config.viscosity || std::ranges::any_of(config.tests, shows_viscosity)) return;
  throw InputError(config.viscosity->where,
                   "no test shows viscosity; add one of kind relaxation or dma, or leave 'viscosity' out");
}

std::vector<Measurements> measurements_of(const std::vector<MaterialTest>& tests, const FitMaterial& material) {
  std::vector<Measurements> result;
  for (const MaterialTest& test : tests) {
    result.push_back({test.y, test.config.weight, [&test, &material](std::span<const double> free) {
                        return test.predicted(material, material.all_values(free), test.x);
                      }});
  }
  return result;
}

void add_stability(FittedMaterial& fit) {
  if (const std::string text = instability_at_rest(fit.material, fit.all); !text.empty()) {
    fit.warnings.push_back(text + "; an input will not take it");
  }
  fit.stability = stability_of(fit.material, fit.all, fit.tests);
  for (const StabilityRange& range : fit.stability) {
    if (range.failures.empty()) continue;
    auto& to = range.is_measured ? fit.warnings : fit.notes;
    to.push_back(fmt::format("{} loading{}: {}", loadings[static_cast<std::size_t>(range.loading)].name,
                             range.is_measured ? "" : ", which was not measured", fmt::join(range.failures, "; ")));
  }
}

}  // namespace

FittedMaterial fit_material(const std::string& text, const std::string& file) {
  FitConfig config = read_fit(text, file);
  check_viscosity_is_tested(config);
  std::vector<MaterialTest> tests = read_tests(config);
  FittedMaterial fit{config, FitMaterial(config.material, config.viscosity), std::move(tests), {}, {}, {}, {}, {}, {}};
  const FitStarts starts(config, fit.material, fit.tests);
  const FitProblem problem(starts.parameters(), measurements_of(fit.tests, fit.material), config.residual);
  fit.outcome = problem.solve(config.starts.value_or(10), starts);
  fit.all = fit.material.all_values(fit.outcome.values);
  if (fit.outcome.num_starts > 0) fit.residuals = problem.residuals(fit.outcome.values);
  fit.warnings = warnings_about(fit.outcome, starts.parameters());
  for (const MaterialTest& test : fit.tests) {
    if (!test.note.empty()) fit.notes.push_back(test.note);
  }
  for (const TestSummary& test : summaries_of(fit)) {
    if (auto warning = warning_about_determination(test.name, test.determination)) {
      fit.warnings.push_back(std::move(*warning));
    }
  }
  if (fit.outcome.num_starts > 0) add_stability(fit);
  return fit;
}

void remove_results(const fs::path& directory) {
  for (const char* name : {"fit.csv", "material.yaml", "fitted.yaml", "report.html"}) {
    std::error_code ignored;  // what cannot be removed cannot be written either, with a message
    fs::remove(directory / name, ignored);
  }
}

ExitCode fit_command(MPI_Comm comm, const std::string& file, const std::string& output, Console& console) {
  std::string text;
  on_root(comm, [&] { text = text_of_fit(file); });
  text = broadcast(comm, std::move(text));
  const fs::path directory = output.empty() ? fs::path("out") / fs::path(file).stem() : fs::path(output);
  if (const FitConfig config = read_fit(text, file); config.input) {
    return fit_run_command(comm, config, directory.string(), console);
  }
  bool is_converged = false;
  on_root(comm, [&] {
    const FittedMaterial fit = fit_material(text, file);
    is_converged = fit.outcome.minimum.is_converged;
    for (const std::string& line : fit_tables(fit)) console.print(line);
    for (const std::string& note : fit.notes) console.report({Severity::note, {}, note});
    for (const std::string& warning : fit.warnings) console.report({Severity::warning, {}, warning});
    if (fit.outcome.num_starts == 0) return remove_results(directory);
    make_directory(directory);
    write_text_atomically(directory / "fit.csv", fit_csv(fit));
    write_text_atomically(directory / "material.yaml", material_yaml(fit));
    write_report(fit, directory);
    console.print(
        fmt::format("results: {0}/report.html, {0}/fit.csv, {0}/material.yaml, {0}/*.svg", directory.string()));
  });
  return any_rank(comm, is_converged) ? ExitCode::done : ExitCode::study_failed;
}

}  // namespace pliant
