#include "study/fit_run.hpp"

#include "base/file.hpp"
#include "base/limits.hpp"
#include "base/text.hpp"
#include "base/units.hpp"
#include "input/analysis.hpp"
#include "input/formats.hpp"
#include "io/history_reader.hpp"
#include "petsc/collective.hpp"
#include "study/fit.hpp"
#include "study/fit_data.hpp"
#include "study/fit_run_report.hpp"
#include "study/fit_tables.hpp"
#include "study/tangent_run.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <filesystem>
#include <optional>

#include <fmt/format.h>

namespace pliant {
namespace {

namespace fs = std::filesystem;

/// The relative error that Newton's method leaves in a motion.
constexpr double error_of_runs = 1e-9;

/// A column of a run over time, with its derivatives.
struct Curve {
  std::vector<double> times;
  std::vector<Sensitive> points;

  /// By the cubic through the four nearest steps.
  Sensitive at(double time) const {
    const auto after = std::ranges::lower_bound(times, time);
    const auto count = std::min<std::size_t>(4, times.size());
    const auto next = static_cast<std::size_t>(after - times.begin());
    const std::size_t first = std::min(next > 2 ? next - 2 : 0, times.size() - count);
    Sensitive result{0.0, std::vector<double>(points.front().slopes.size(), 0.0)};
    for (std::size_t i = first; i < first + count; ++i) {
      double weight = 1.0;
      for (std::size_t k = first; k < first + count; ++k) {
        if (k != i) weight *= (time - times[k]) / (times[i] - times[k]);
      }
      result.value += weight * points[i].value;
      for (std::size_t j = 0; j < result.slopes.size(); ++j) result.slopes[j] += weight * points[i].slopes[j];
    }
    return result;
  }
};

std::string lower_case(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// `is_static`: `time` is the load factor.
FitTarget read_target(const FitTargetConfig& config, const std::string& folder, double end, bool is_static) {
  FitTarget target{config, {}, std::string(unit_of_column(config.column)), 1.0, {}, {}, {}, ""};
  if (target.unit.empty()) target.unit = "1";
  const std::string file = (fs::path(folder) / config.data.value).string(), name = lower_case(config.column);
  target.name = fmt::format("{} ({})", config.column, fs::path(config.data.value).filename().string());
  auto [columns, note] = read_measurements(
      file, config.data.where, std::vector<std::vector<ColumnForm>>{{{"time", "s"}}, {{name, target.unit}}});
  target.note = std::move(note);
  target.times = std::move(columns[0]);
  target.values = std::move(columns[1]);
  for (const double t : target.times) {
    if (t >= 0.0 && t <= end * (1.0 + 1e-12)) continue;
    if (is_static) {
      throw InputError(config.data.where,
                       fmt::format("'{}' has a row at time = {:g}, but in a static run `time` is the load factor, from "
                                   "0 to 1; leave the row out, or scale the loads",
                                   config.data.value, t));
    }
    throw InputError(
        config.data.where,
        fmt::format("'{}' has a row at t = {:g} s, but the run goes from 0 to {:g} s; leave the row out, or "
                    "give the input another 'time.end'",
                    config.data.value, t, end));
  }
  const auto largest = std::ranges::max(target.values, {}, [](double v) { return std::abs(v); });
  target.scale = largest != 0.0 ? std::abs(largest) : 1.0;
  if (config.scale) {
    Diagnostics diagnostics;
    quantity(target.unit, Range::above(0)).read(*config.scale, "scale", diagnostics, target.scale);
    diagnostics.throw_if_errors();
  }
  return target;
}

std::vector<FreeParameter> read_parameters(const FitConfig& config, const VariedInput& input) {
  std::vector<FreeParameter> parameters;
  Diagnostics diagnostics;
  for (std::size_t n = 0; n < config.parameters.size(); ++n) {
    const NamedNode& given = config.parameters[n];
    const VariedNumber& number = input.numbers()[n];
    std::array<double, 2> bounds{};
    if (!array_of<2>(quantity(number.unit)).read(given.node, given.name, diagnostics, bounds)) continue;
    const auto [lower, upper] = bounds;
    if (!(lower < upper)) {
      diagnostics.add(given.node.where,
                      fmt::format("'{}' must be [lowest, highest], the first below the second", given.name));
      continue;
    }
    constexpr double decade = 10.0;
    const bool is_log = lower > 0.0 && upper >= decade * lower;
    parameters.push_back({given.name, number.unit, lower, upper, std::max(std::abs(lower), std::abs(upper)),
                          is_log ? FreeParameter::Fitted::logarithm : FreeParameter::Fitted::linear});
  }
  diagnostics.throw_if_errors();
  return parameters;
}

/// The runs that the optimiser asks for, each once.
class FitRuns {
 public:
  FitRuns(MPI_Comm comm, const VariedInput& input, std::span<const FitTarget> targets,
          const std::vector<FreeParameter>& parameters, Console& console)
      : input_(input), targets_(targets), parameters_(parameters), console_(console), mesh_(mesh_of(comm, input)) {
    for (const FreeParameter& p : parameters) sizes_.push_back(p.upper - p.lower);
  }

  /// The n-th target at its times.
  std::vector<Sensitive> predict(std::size_t n, std::span<const double> values) {
    const std::vector<Curve>& curves = run(std::vector<double>(values.begin(), values.end()));
    std::vector<Sensitive> result;
    for (const double time : targets_[n].times) {
      result.push_back(curves.empty() ? Sensitive{nan, std::vector<double>(parameters_.size(), nan)}
                                      : curves[n].at(time));
      for (double* number : numbers_of(result.back())) *number /= targets_[n].scale;
    }
    return result;
  }
  int num_runs() const { return static_cast<int>(known_.size()); }

 private:
  static std::vector<double*> numbers_of(Sensitive& s) {
    std::vector<double*> all{&s.value};
    for (double& slope : s.slopes) all.push_back(&slope);
    return all;
  }

  /// The curves of the targets; none if the run failed.
  const std::vector<Curve>& run(const std::vector<double>& values) {
    // The optimiser returns to the same values but for rounding errors.
    const auto is_same = [&](const Known& known) {
      return std::ranges::equal(known.values, values, [](double a, double b) {
        return std::abs(a - b) <= 1e-13 * std::max(std::abs(a), std::abs(b));
      });
    };
    if (const auto found = std::ranges::find_if(known_, is_same); found != known_.end()) return found->curves;
    std::vector<Curve> curves;
    std::string outcome;
    try {
      curves = curves_of(values);
      outcome = fmt::format("rms residual {:.4g}", rms(curves));
    } catch (const SolveError& error) {
      outcome = fmt::format("the run fails: {}", error.what());
    } catch (const InputError& error) {
      if (known_.empty()) throw;
      outcome = fmt::format("the input does not take these values: {}", error.what());
    }
    std::string line = fmt::format("run {}:", known_.size() + 1);
    for (std::size_t j = 0; j < values.size(); ++j)
      line += fmt::format(" {} = {:.6g};", parameters_[j].name, values[j]);
    console_.print(fmt::format("{} {}", line, outcome));
    return known_.emplace_back(Known{values, std::move(curves)}).curves;
  }

  std::vector<Curve> curves_of(const std::vector<double>& values) {
    std::vector<std::string> wanted;
    for (const FitTarget& target : targets_) wanted.push_back(target.config.column);
    TangentRun run(mesh_, input_, values, wanted, sizes_);
    std::vector<std::size_t> places;
    for (const FitTarget& target : targets_) places.push_back(place_of(target, run.columns()));
    double last = 0.0;  // up to which there are measurements
    for (const FitTarget& target : targets_) last = std::max(last, std::ranges::max(target.times));
    std::vector<Curve> curves(targets_.size());
    const auto keep = [&] {
      for (std::size_t n = 0; n < targets_.size(); ++n) {
        Sensitive point{run.values()[places[n]], {}};
        for (std::size_t j = 0; j < parameters_.size(); ++j) point.slopes.push_back(run.slopes(j)[places[n]]);
        curves[n].times.push_back(run.time());
        curves[n].points.push_back(std::move(point));
      }
    };
    for (keep(); !run.finished() && run.time() < last; keep()) run.advance();
    return curves;
  }

  double rms(const std::vector<Curve>& curves) const {
    double sum = 0.0, count = 0.0;
    for (std::size_t n = 0; n < targets_.size(); ++n) {
      for (std::size_t i = 0; i < targets_[n].times.size(); ++i, ++count) {
        sum += std::pow((curves[n].at(targets_[n].times[i]).value - targets_[n].values[i]) / targets_[n].scale, 2);
      }
    }
    return std::sqrt(sum / count);
  }

  static std::size_t place_of(const FitTarget& target, const std::vector<std::string>& columns) {
    const auto found = std::ranges::find(columns, target.config.column);
    if (found != columns.end()) return static_cast<std::size_t>(found - columns.begin());
    throw InputError(target.config.where,
                     fmt::format("history.csv of the input has no column '{}'{}; it has {}", target.config.column,
                                 did_you_mean(target.config.column, columns), joined(columns)));
  }

  const VariedInput& input_;
  std::span<const FitTarget> targets_;
  const std::vector<FreeParameter>& parameters_;
  Console& console_;
  Mesh mesh_;
  std::vector<double> sizes_;
  struct Known {
    std::vector<double> values;
    std::vector<Curve> curves;
  };
  std::deque<Known> known_;  // all runs so far
};

std::vector<std::string> keys_of(const FitConfig& config) {
  std::vector<std::string> keys;
  for (const NamedNode& given : config.parameters) keys.push_back(given.name);
  return keys;
}

/// The n-th start: the values of the input, then points that fill the bounds evenly.
std::vector<double> start(int n, const std::vector<FreeParameter>& parameters, const VariedInput& input) {
  const auto point = halton_point(std::max(n, 1), parameters.size());
  std::vector<double> values;
  for (std::size_t j = 0; j < parameters.size(); ++j) {
    const FreeParameter& p = parameters[j];
    const bool is_log = p.fitted == FreeParameter::Fitted::logarithm;
    const double between =
        is_log ? p.lower * std::pow(p.upper / p.lower, point[j]) : p.lower + (p.upper - p.lower) * point[j];
    values.push_back(n == 0 ? std::clamp(input.numbers()[j].value, p.lower, p.upper) : between);
  }
  return values;
}

FittedRun fit_run(MPI_Comm comm, const FitConfig& config, const std::string& directory, Console& console) {
  const std::string folder = fs::path(config.file).parent_path().string();
  const std::string file = (fs::path(folder) / config.input->value).string();
  const VariedInput input(input_text(comm, file), file, {}, keys_of(config), config.file + ": parameters");
  FittedRun fit{config, input.numbers(), {}, {}, {}, 0, {}, {}};
  const std::vector<FreeParameter> parameters = read_parameters(config, input);
  const bool is_static = analysis_of(input.given()) == Analysis::static_equilibrium;
  on_every_rank(comm, [&] {
    for (const FitTargetConfig& target : config.targets) {
      fit.targets.push_back(read_target(target, folder, is_static ? 1.0 : input.given().time.end, is_static));
    }
  });
  FitRuns runs(comm, input, fit.targets, parameters, console);
  on_root(comm, [&] { remove_results(directory); });
  std::vector<Measurements> measurements;
  for (std::size_t n = 0; n < fit.targets.size(); ++n) {
    const FitTarget& target = fit.targets[n];
    std::vector<double> scaled = target.values;
    for (double& value : scaled) value /= target.scale;
    measurements.push_back({std::move(scaled), target.config.weight,
                            [&runs, n](std::span<const double> values) { return runs.predict(n, values); }});
  }
  const FitProblem problem(parameters, std::move(measurements), ResidualKind::absolute, error_of_runs);
  fit.outcome = problem.solve(config.starts.value_or(1), [&](int n) { return start(n, parameters, input); });
  if (fit.outcome.num_starts == 0) {
    throw SolveError("no run came to the times of the measurements; see the reasons above, and try closer bounds");
  }
  fit.residuals = problem.residuals(fit.outcome.values);
  for (std::size_t n = 0; n < fit.targets.size(); ++n) {
    for (const Sensitive& point : runs.predict(n, fit.outcome.values)) {
      fit.targets[n].fitted.push_back(point.value * fit.targets[n].scale);
    }
  }
  fit.num_runs = runs.num_runs();
  fit.input = dump(input.at(fit.outcome.values));
  fit.warnings = warnings_about(fit.outcome, parameters);
  for (std::size_t n = 0; n < fit.targets.size(); ++n) {
    if (auto warning = warning_about_determination(fit.targets[n].name, determination_of(fit, n))) {
      fit.warnings.push_back(std::move(*warning));
    }
  }
  return fit;
}

}  // namespace

ExitCode fit_run_command(MPI_Comm comm, const FitConfig& config, const std::string& directory, Console& console) {
  const FittedRun fit = fit_run(comm, config, directory, console);
  for (const std::string& line : fit_tables(fit)) console.print(line);
  for (const FitTarget& target : fit.targets) {
    if (!target.note.empty()) console.report({Severity::note, {}, target.note});
  }
  for (const std::string& warning : fit.warnings) console.report({Severity::warning, {}, warning});
  on_root(comm, [&] { write_fit(fit, directory); });
  console.print(fmt::format("results: {0}/report.html, {0}/fit.csv, {0}/fitted.yaml, {0}/*.svg", directory));
  return fit.outcome.minimum.is_converged ? ExitCode::done : ExitCode::study_failed;
}

}  // namespace pliant
