#include "study/converge.hpp"

#include "base/file.hpp"
#include "base/limits.hpp"
#include "io/history_writer.hpp"
#include "io/svg_plot.hpp"
#include "model/mesh_source.hpp"
#include "model/model.hpp"
#include "petsc/collective.hpp"
#include "solver/petsc_method.hpp"
#include "study/level_results.hpp"
#include "study/level_run.hpp"
#include "study/sample.hpp"
#include "study/studied_input.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>

#include <fmt/format.h>

namespace pliant {
namespace {

constexpr double tolerance_factor = 3.0;  // an adaptive run that misses its tolerance by more has failed
constexpr double rounding = 1e-9;         // errors below this part of the solution are Newton's method's
/// Steps of the reference in the finest one; the latter is of the first order, which makes the observed one 1.05.
constexpr double steps_of_reference = 4.0, steps_of_quasistatic_reference = 16.0;

/// A line of the table.
struct Row {
  std::string method;
  int level = 0;
  double step = 0.0;  ///< [s]; by tolerance the mean one
  double size = 0.0;  ///< of the mesh [m]; by tolerance the relative tolerance
  double error_q = nan, error_v = nan;
  double order_q = nan, order_v = nan;
  long long newton_iterations = 0;
  double seconds = 0.0;
  double over_tolerance = nan;                  ///< by tolerance: the error in units of it
  bool is_exact_q = false, is_exact_v = false;  ///< in time: only rounding errors
  std::string failure;
};

/// Edge of the regular tetrahedron whose volume is the mean of the cells'.
double mesh_size(const MeshReport& mesh) {
  const long long count = mesh.elements.tetrahedra > 0 ? mesh.elements.tetrahedra : mesh.num_cells;
  return std::cbrt(6.0 * std::sqrt(2.0) * mesh.volume / static_cast<double>(count));
}

int theoretical_order(const Config& config) {
  if (const Method* method = integrator_of(config)) return method->order;
  const PetscMethod* petsc = find_petsc_method(method_name(config.time.method));
  return petsc != nullptr ? petsc->order : 0;
}

class Study {
 public:
  Study(MPI_Comm comm, const StudyOptions& options, std::vector<Config> configs, Console& console)
      : comm_(comm),
        options_(options),
        configs_(std::move(configs)),
        console_(console),
        results_(options.results,
                 {size_label(), options.refine == Refine::tolerance ? 10.0 : 2.0, options.refine != Refine::space},
                 dump(first())) {}

  ExitCode operator()() {
    switch (options_.refine) {
      case Refine::time:
        in_time();
        break;
      case Refine::space:
        in_space();
        break;
      case Refine::tolerance:
        by_tolerance();
        break;
    }
    for (const std::string& line : results_.tables()) console_.print(line);
    write_files();
    return verdict();
  }

 private:
  const Config& first() const { return configs_.front(); }

  // ---- studies

  void in_time() {
    const Mesh mesh = read_mesh(comm_, mesh_source(first()));
    const bool has_inertia = analysis_of(first()) == Analysis::dynamic;
    const double steps = has_inertia ? steps_of_reference : steps_of_quasistatic_reference;
    const Config finest = reference_with(first(), std::ldexp(first().time.step, 1 - options_.levels) / steps);
    Model model(mesh, finest);
    const LevelRun reference = reference_run(finest, model);
    for (const Config& config : configs_) {
      for (int level = 0; level < options_.levels; ++level) {
        Config finer = config;
        finer.time.step = std::ldexp(config.time.step, -level);
        finer.time.min_step = finer.time.step / 1024.0;
        Row row = row_of(finer, level, finer.time.step, mesh_size(model.mesh_report()));
        compare(model, solve(finer, mesh, row), reference, row);
        row.is_exact_q = row.error_q <= rounding * reference.largest_q && row.error_q > 0.0;
        row.is_exact_v = row.error_v <= rounding * reference.largest_v && row.error_v > 0.0;
        add(std::move(row), 2.0);
      }
    }
  }

  void by_tolerance() {
    const Mesh mesh = read_mesh(comm_, mesh_source(first()));
    Config finest = reference_with(first(), first().time.step);
    finest.time.adaptive = first().time.adaptive;
    set_tolerance(finest, options_.levels + 1);
    Model model(mesh, finest);
    const LevelRun reference = reference_run(finest, model);
    for (const Config& config : configs_) {
      for (int level = 0; level < options_.levels; ++level) {
        Config finer = config;
        set_tolerance(finer, level);
        const AdaptiveConfig& to = *finer.time.adaptive;
        Row row = row_of(finer, level, nan, to.relative);
        const LevelRun solution = solve(finer, mesh, row);
        row.step = finer.time.end / static_cast<double>(solution.steps);
        compare(model, solution, reference, row);
        row.over_tolerance = std::max(row.error_q / (to.absolute + to.relative * reference.largest_q),
                                      row.error_v / (to.absolute_velocity + to.relative * reference.largest_v));
        add(std::move(row), 10.0);
      }
    }
  }

  void in_space() {
    for (const Config& config : configs_) {
      std::optional<Sample> sample;
      SampledState coarser;  // at the points of the sample
      Row row;
      long long num_coarser = 0;
      for (int level = 0; level <= options_.levels; ++level) {
        Config finer = config;
        finer.mesh.refine += level;
        Model model(comm_, finer);
        Row next = row_of(finer, level, finer.time.step, mesh_size(model.mesh_report()));
        if (level > 0) {
          const auto factor = static_cast<double>(model.mesh_report().num_cells) / static_cast<double>(num_coarser);
          console_.print(fmt::format("level {}: {}, {:.3g} times those of level {}", level,
                                     in_words(model.mesh_report().elements), factor, level - 1));
        }
        num_coarser = model.mesh_report().num_cells;
        const LevelRun solution = solve(finer, model, next);
        console_.print(fmt::format("level {} is solved: {}, {} Newton iterations, {:.3g} s", level,
                                   in_words(model.mesh_report().elements), solution.newton_iterations,
                                   solution.seconds));
        if (sample) {
          const SampledState state = sample->read(model.layout(), solution.q.get(), solution.v.get());
          row.error_q = sample->distance(coarser.u, state.u);
          row.error_v = sample->distance(coarser.v, state.v);
          if (!solution.failure.empty()) row.failure = "the next level failed: " + solution.failure;
          add(std::move(row), 2.0);
        }
        row = std::move(next);
        row.newton_iterations = solution.newton_iterations;
        row.seconds = solution.seconds;
        row.failure = solution.failure;
        if (level == options_.levels) break;
        sample.emplace(model.layout());
        coarser = sample->read(model.layout(), solution.q.get(), solution.v.get());
      }
    }
  }

  static Config reference_with(const Config& config, double step) {
    Config reference = config;
    if (analysis_of(config) == Analysis::dynamic) reference.time.method.kind = *find_method("dirk33");
    reference.time.adaptive.reset();
    reference.time.step = step;
    reference.time.min_step = step / 1024.0;
    for (auto& body : reference.bodies) {  // a rate that costs the compared methods their order would cost it its own
      for (auto& mechanism : body.viscosity) mechanism.rate.reset();
    }
    return reference;
  }

  static void set_tolerance(Config& config, int level) {
    AdaptiveConfig& to = *config.time.adaptive;
    const double factor = std::pow(10.0, -level);
    to.relative *= factor;
    to.absolute *= factor;
    to.absolute_velocity *= factor;
  }

  // ---- runs

  LevelRun reference_run(const Config& config, Model& model) {
    console_.print(
        fmt::format("solving the reference: {}, steps of {:.3g} s", method_name(config.time.method), config.time.step));
    LevelRun reference = run_level(config, model, options_.results, "reference", console_);
    if (!reference.failure.empty()) throw SolveError("the reference solution failed: " + reference.failure);
    console_.print(fmt::format("the reference is solved: {}, {} steps, {} Newton iterations, {:.3g} s",
                               method_name(config.time.method), reference.steps, reference.newton_iterations,
                               reference.seconds));
    results_.set_reference(reference.results);
    return reference;
  }

  LevelRun solve(const Config& config, Model& model, const Row& row) {
    if (row.level == 0) report_new_warnings(model, console_);
    const std::string name = fmt::format("{}, level {}", row.method, row.level);
    LevelRun run = run_level(config, model, options_.results, name, console_);
    results_.add(row.method, row.level, abscissa(row), run.results);
    return run;
  }

  LevelRun solve(const Config& config, const Mesh& mesh, const Row& row) {
    Model model(mesh, config);
    return solve(config, model, row);
  }

  // ---- rows

  Row row_of(const Config& config, int level, double step, double size) const {
    Row row;
    row.method = method_name(config.time.method);
    row.level = level;
    row.step = step;
    row.size = size;
    return row;
  }

  void compare(const Model& model, const LevelRun& solution, const LevelRun& reference, Row& row) const {
    row.error_q = mean_square_distance(model, solution.q.get(), reference.q.get());
    row.error_v = mean_square_distance(model, solution.v.get(), reference.v.get());
    row.newton_iterations = solution.newton_iterations;
    row.seconds = solution.seconds;
    row.failure = solution.failure;
  }

  /// `factor`: the refinement between two levels.
  void add(Row row, double factor) {
    if (!row.failure.empty()) row.error_q = row.error_v = nan;
    if (!rows_.empty() && rows_.back().method == row.method) {
      row.order_q = observed_order(rows_.back().error_q, row.error_q, factor);
      row.order_v = observed_order(rows_.back().error_v, row.error_v, factor);
    }
    if (rows_.empty()) print_header();
    print(row);
    rows_.push_back(std::move(row));
  }

  // ---- what users see

  bool is_static() const { return analysis_of(first()) == Analysis::static_equilibrium; }

  int expected_order(const Config& config) const {
    switch (options_.refine) {
      case Refine::time:
        return theoretical_order(config);
      case Refine::space:
        return static_cast<int>(config.element) + 1;
      case Refine::tolerance:
        return 1;
    }
    return 0;
  }

  void print_header() const {
    console_.print(fmt::format("{:<18} {:>5} {:>10} {:>10} {:>12} {:>12} {:>7} {:>7} {:>8} {:>8}{}", "method", "level",
                               is_static() ? "" : "step [s]",
                               options_.refine == Refine::tolerance ? "relative" : "h [m]", "error u [m]", "v [m/s]",
                               "order u", "v", "newton", "wall [s]",
                               options_.refine == Refine::tolerance ? "  error/tolerance" : ""));
  }

  void print(const Row& row) const {
    const auto order = [](double p) { return std::isfinite(p) ? fmt::format("{:.2f}", p) : std::string("-"); };
    console_.print(fmt::format("{:<18} {:>5} {:>10.4g} {:>10.4g} {:>12.4e} {:>12.4e} {:>7} {:>7} {:>8} {:>8.2f}{}{}",
                               row.method, row.level, row.step, row.size, row.error_q, row.error_v, order(row.order_q),
                               order(row.order_v), row.newton_iterations, row.seconds,
                               std::isfinite(row.over_tolerance) ? fmt::format("  {:.2f}", row.over_tolerance) : "",
                               row.failure.empty() ? "" : "  failed: " + row.failure));
  }

  void write_files() const {
    const std::filesystem::path directory = first().output.directory;
    on_root(comm_, [&] {
      make_directory(directory);
      write_text_atomically(directory / "convergence.csv", csv());
    });
    write_svg(comm_, directory / "convergence.svg", error_plot());
    std::string files = fmt::format("results: {0}/convergence.csv, {0}/convergence.svg", directory.string());
    if (options_.refine != Refine::space) {
      write_svg(comm_, directory / "work.svg", work_plot());
      files += fmt::format(", {}/work.svg", directory.string());
    }
    for (const std::string& file : results_.write(comm_, directory, first().title)) files += ", " + file;
    console_.print(files);
  }

  std::string csv() const {
    std::string text = csv_header({"method", "level", "step", "size", "error_displacement", "error_velocity",
                                   "order_displacement", "order_velocity", "newton_iterations", "seconds"}) +
                       "\n";
    for (const Row& row : rows_) {
      const std::array<double, 9> numbers{static_cast<double>(row.level),
                                          row.step,
                                          row.size,
                                          row.error_q,
                                          row.error_v,
                                          row.order_q,
                                          row.order_v,
                                          static_cast<double>(row.newton_iterations),
                                          row.seconds};
      text += csv_header({row.method}) + "," + csv_row(numbers) + "\n";
    }
    return text;
  }

  double abscissa(const Row& row) const { return options_.refine == Refine::time ? row.step : row.size; }

  /// The error of each method over x(row).
  template <class X>
  std::vector<PlotSeries> series(const X& x) const {
    std::vector<PlotSeries> all;
    for (const Row& row : rows_) {
      if (all.empty() || all.back().name != row.method) all.push_back({row.method, {}, {}});
      all.back().x.push_back(x(row));
      all.back().y.push_back(row.error_q);
    }
    return all;
  }

  std::string size_label() const {
    return options_.refine == Refine::time    ? "step [s]"
           : options_.refine == Refine::space ? "mesh size [m]"
                                              : "relative tolerance";
  }

  Plot error_plot() const {
    Plot plot;
    plot.title = first().title.empty() ? "convergence" : first().title;
    plot.x_label = size_label();
    plot.y_label = "error of the displacement [m]";
    plot.series = series([this](const Row& row) { return abscissa(row); });
    for (const Config& config : configs_) {
      const double order = expected_order(config);
      if (std::ranges::find(plot.slopes, order) == plot.slopes.end()) plot.slopes.push_back(order);
    }
    return plot;
  }

  Plot work_plot() const {
    Plot plot;
    plot.title = first().title.empty() ? "work and precision" : first().title;
    plot.x_label = "wall time [s]";
    plot.y_label = "error of the displacement [m]";
    plot.series = series([](const Row& row) { return row.seconds; });
    return plot;
  }

  // ---- verdict

  ExitCode verdict() const {
    std::vector<std::string> shortfalls;
    for (const Config& config : configs_) {
      const std::string method = method_name(config.time.method);
      const auto last = std::find_if(rows_.rbegin(), rows_.rend(), [&](const Row& r) { return r.method == method; });
      const int expected = expected_order(config);
      const bool of_velocity = last->is_exact_q || (!is_static() && !last->is_exact_v && last->order_v < last->order_q);
      const double lowest = of_velocity ? last->order_v : last->order_q;
      if (last->is_exact_q)
        console_.print(method + ": displacements have rounding errors only; longer steps give the same");
      if (last->is_exact_q && last->is_exact_v) continue;
      if (last->failure.empty() && std::isnan(lowest)) {
        shortfalls.push_back(
            fmt::format("{}: no order can be measured, because all errors are 0; check that something moves", method));
      } else if (!last->failure.empty()) {
        shortfalls.push_back(fmt::format("{}: the finest level was not solved", method));
      } else if (!(lowest >= expected - order_shortfall) && options_.refine != Refine::tolerance) {
        shortfalls.push_back(fmt::format("{}: order {:.2f} of the {} is observed, {} expected", method, lowest,
                                         of_velocity ? "velocity" : "displacement", expected));
      }
      for (const Row& row : rows_) {
        if (row.method != method || !(row.over_tolerance > tolerance_factor)) continue;
        shortfalls.push_back(
            fmt::format("{}: the error is {:.1f} times the tolerance of {:.3g}", method, row.over_tolerance, row.size));
      }
    }
    if (shortfalls.empty()) return ExitCode::done;
    for (const auto& text : shortfalls) console_.warn(text);
    if (!options_.checks_orders) return ExitCode::done;
    console_.warn(
        "the study falls short of theory: coarse levels may not resolve the motion yet, loads or the start may "
        "not be smooth, corners may keep the solution from being smooth (docs: convergence); --no-check "
        "accepts any order");
    return ExitCode::study_failed;
  }

  MPI_Comm comm_;
  StudyOptions options_;
  std::vector<Config> configs_;
  Console& console_;
  LevelResults results_;
  std::vector<Row> rows_;
};

}  // namespace

ExitCode converge_command(MPI_Comm comm, const std::string& file, const std::vector<Override>& overrides,
                          const StudyOptions& options, Console& console) {
  return Study(comm, options, read_studied_inputs(comm, file, overrides, options), console)();
}

}  // namespace pliant
