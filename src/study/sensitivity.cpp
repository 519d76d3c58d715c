#include "study/sensitivity.hpp"

#include "base/file.hpp"
#include "base/text.hpp"
#include "io/history_reader.hpp"
#include "io/history_writer.hpp"
#include "io/svg_plot.hpp"
#include "petsc/collective.hpp"
#include "study/tangent_run.hpp"

#include <algorithm>
#include <filesystem>
#include <optional>

#include <fmt/format.h>

namespace pliant {
namespace {

namespace fs = std::filesystem;

/// The derivatives of one column over time.
struct SensitiveColumn {
  std::string name;
  std::size_t place;                        ///< among the columns of the history
  std::vector<double> values;               ///< of each step
  std::vector<std::vector<double>> slopes;  ///< of each number, of each step
};

std::vector<SensitiveColumn> find_columns(const std::vector<std::string>& names, const std::vector<std::string>& all) {
  std::vector<SensitiveColumn> result;
  for (const std::string& name : names) {
    const auto found = std::ranges::find(all, name);
    if (found == all.end()) {
      throw InputError({"--of " + name, 0, 0}, fmt::format("history.csv has no column '{}'{}; it has {}", name,
                                                           did_you_mean(name, all), joined(all)));
    }
    result.push_back({name, static_cast<std::size_t>(found - all.begin()), {}, {}});
  }
  return result;
}

class SensitivityStudy {
 public:
  SensitivityStudy(MPI_Comm comm, const VariedInput& input, const SensitivityOptions& options, Console& console)
      : comm_(comm), numbers_(input.numbers()), console_(console) {
    std::vector<double> values;
    for (const VariedNumber& number : numbers_) values.push_back(number.value);
    on_root(comm, [&] { make_directory(input.given().output.directory); });
    {
      const Mesh mesh = mesh_of(comm, input);
      run_.emplace(mesh, input, values, options.columns);
    }
    columns_ = find_columns(options.columns, run_->columns());
    for (SensitiveColumn& column : columns_) column.slopes.resize(numbers_.size());
    for (const auto& diagnostic : run_->model().diagnostics()) console_.report(diagnostic);
  }

  ExitCode operator()() {
    keep_row();
    try {
      while (!run_->finished()) {
        run_->advance();
        keep_row();
        console_.progress(fmt::format("t = {:.6g} s", run_->time()));
      }
    } catch (const SolveError&) {
      write();
      throw;
    }
    write();
    print();
    return ExitCode::done;
  }

 private:
  void keep_row() {
    times_.push_back(run_->time());
    for (SensitiveColumn& column : columns_) {
      column.values.push_back(run_->values()[column.place]);
      for (std::size_t n = 0; n < numbers_.size(); ++n) column.slopes[n].push_back(run_->slopes(n)[column.place]);
    }
  }

  bool is_static() const { return analysis_of(run_->config()) == Analysis::static_equilibrium; }

  void write() const {
    const fs::path directory = run_->config().output.directory;
    on_root(comm_, [&] {
      write_text_atomically(directory / "sensitivity.csv", csv());
      std::string numbers = "number,value,unit\n";
      for (const VariedNumber& p : numbers_)
        numbers += fmt::format("{},{},{}\n", p.key, format_number(p.value), p.unit);
      write_text_atomically(directory / "numbers.csv", numbers);
    });
    for (const SensitiveColumn& column : columns_) {
      write_svg(comm_, directory / fmt::format("sensitivity_{}.svg", column.name), plot(column));
    }
  }

  std::string csv() const {
    std::vector<std::string> names{"time"};
    for (const SensitiveColumn& column : columns_) {
      names.push_back(column.name);
      for (const VariedNumber& p : numbers_) {
        names.push_back(fmt::format("d({})/d({})", column.name, p.key));
        names.push_back(fmt::format("{1}*d({0})/d({1})", column.name, p.key));
      }
    }
    std::string text = csv_header(names) + '\n';
    for (std::size_t t = 0; t < times_.size(); ++t) {
      std::vector<double> row{times_[t]};
      for (const SensitiveColumn& column : columns_) {
        row.push_back(column.values[t]);
        for (std::size_t n = 0; n < numbers_.size(); ++n) {
          row.push_back(column.slopes[n][t]);
          row.push_back(numbers_[n].value * column.slopes[n][t]);
        }
      }
      text += csv_row(row) + '\n';
    }
    return text;
  }

  Plot plot(const SensitiveColumn& column) const {
    Plot plot;
    plot.title = fmt::format("{}: relative sensitivities", column.name);
    plot.x_label = is_static() ? "load factor" : "time [s]";
    const std::string_view unit = unit_of_column(column.name);
    plot.y_label = fmt::format("p d({})/dp{}", column.name, unit.empty() ? "" : fmt::format(" [{}]", unit));
    plot.scale = Scale::linear;
    for (std::size_t n = 0; n < numbers_.size(); ++n) {
      std::vector<double> scaled = column.slopes[n];
      for (double& s : scaled) s *= numbers_[n].value;
      plot.series.push_back({numbers_[n].key, times_, std::move(scaled), SeriesStyle::line});
    }
    return plot;
  }

  void print() const {
    const std::string end =
        fmt::format("{} = {:.6g}{}", is_static() ? "load factor" : "t", times_.back(), is_static() ? "" : " s");
    std::size_t width = 6;
    for (const VariedNumber& p : numbers_) width = std::max(width, p.key.size());
    console_.print(fmt::format("derivatives at {}, in SI units", end));
    for (const SensitiveColumn& column : columns_) {
      console_.print(fmt::format("{} = {:.9g}", column.name, column.values.back()));
      console_.print(fmt::format("  {:<{}}  {:>13}  {:<8}  {:>16}  {:>16}", "number", width, "value", "unit",
                                 "derivative", "for 1 % of it"));
      for (std::size_t n = 0; n < numbers_.size(); ++n) {
        const VariedNumber& p = numbers_[n];
        const double slope = column.slopes[n].back();
        console_.print(fmt::format("  {:<{}}  {:>13.7g}  {:<8}  {:>16.9g}  {:>16.6g}", p.key, width, p.value,
                                   p.unit == "1" ? "" : p.unit, slope, 0.01 * p.value * slope));
      }
    }
    console_.print(fmt::format("results: {0}/sensitivity.csv, {0}/sensitivity_*.svg", run_->config().output.directory));
  }

  MPI_Comm comm_;
  std::vector<VariedNumber> numbers_;
  Console& console_;
  std::optional<TangentRun> run_;
  std::vector<SensitiveColumn> columns_;
  std::vector<double> times_;
};

}  // namespace

ExitCode sensitivity_command(MPI_Comm comm, const std::string& file, const std::vector<Override>& changes,
                             const SensitivityOptions& options, Console& console) {
  std::string keys;
  for (const std::string& key : options.numbers) keys += (keys.empty() ? "" : ",") + key;
  const VariedInput input(input_text(comm, file), file, changes, options.numbers, "--to " + keys);
  return SensitivityStudy(comm, input, options, console)();
}

}  // namespace pliant
