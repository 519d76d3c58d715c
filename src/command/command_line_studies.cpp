// The commands that take many runs: sweeps, comparisons, derivatives and fits.
#include "base/text.hpp"
#include "base/units.hpp"
#include "command/command_help.hpp"
#include "command/command_line.hpp"
#include "petsc/session.hpp"
#include "study/fit.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace pliant {
namespace {

/// Did mpirun start it?
bool is_part_of_a_job(const Environment& environment) {
  return std::ranges::any_of(environment, [](const std::string& v) { return v.starts_with("OMPI_COMM_WORLD_SIZE="); });
}

}  // namespace

void CommandLine::add_results(CLI::App& to, const std::string& what) {
  to.add_option("--result", arguments_.results,
                fmt::format("a number of {}: FUNCTION(COLUMN) of its history, e.g. max(tip_z), or "
                            "NAME=FUNCTION(COLUMN). May be repeated",
                            what))
      ->allow_extra_args(false)
      ->type_name("FUNCTION(COLUMN)");
}

std::vector<RunNumber> CommandLine::run_numbers() const {
  std::vector<RunNumber> numbers;
  for (const std::string& text : arguments_.results) numbers.push_back(parse_run_number(text, "--result"));
  return numbers;
}

void CommandLine::add_sweep() {
  CLI::App* sweep = app_.add_subcommand("sweep", "run the input once for each of several values, side by side");
  sweep->footer(
      examples({"pliant sweep beam.yaml --set \"time.step=[10 ms, 5 ms]\"",
                "pliant sweep beam.yaml --set \"element=[P1, P2]\" --set \"time.method=[bdf2, dirk22]\" --jobs 2",
                "pliant sweep beam.yaml --set \"bodies.0.density=[900, 1000, 1100]\" --result \"max(tip_z)\"",
                "pliant sweep beam.yaml --set bodies.0.density=900..1100 --samples 20 --result \"max(tip_z)\""}));
  sweep->add_option("INPUT", arguments_.file, "the input file (YAML)")->required();
  sweep
      ->add_option("--set", arguments_.settings,
                   "KEY.PATH=[VALUE, ...]: the values to try; several lists: every combination. KEY.PATH=LOW..HIGH: a "
                   "range for --samples. KEY.PATH=VALUE: the same for all runs. May be repeated")
      ->required()
      ->allow_extra_args(false);
  add_output(*sweep, "directory for the runs, sweep.csv and the plots");
  add_results(*sweep, "each run, for the table and a plot over the values");
  auto* samples = sweep
                      ->add_option("--samples", arguments_.sweep.samples,
                                   "points to take from all ranges together, spread evenly over each of them (Latin "
                                   "hypercube)")
                      ->check(CLI::Range(1, 1000))
                      ->type_name("N");
  sweep->add_option("--seed", arguments_.sweep.seed, "another number takes other samples; the same takes the same")
      ->type_name("N")
      ->capture_default_str()
      ->needs(samples);
  sweep
      ->add_option("--logarithmic", arguments_.sweep.logarithmic,
                   "keys whose ranges are sampled by factors: as many samples from 1 to 10 as from 10 to 100")
      ->delimiter(',')
      ->type_name("KEY,...")
      ->needs(samples);
  sweep
      ->add_option("--together", arguments_.sweep.together,
                   "keys whose lists are gone through side by side: the first values of all, then the second. May be "
                   "repeated")
      ->type_name("KEY,...")
      ->allow_extra_args(false);
  sweep->add_flag("--continue", arguments_.sweep.continues, "skip finished runs, continue those that were begun");
  sweep->add_option("--jobs", arguments_.sweep.at_once, "runs at a time; default: as many as the processors allow")
      ->check(CLI::Range(1, 1024))
      ->type_name("N");
  sweep->add_option("--ranks", arguments_.sweep.ranks, "ranks of each run")
      ->check(CLI::Range(1, 1024))
      ->type_name("N")
      ->capture_default_str();
  sweep->callback([this] {
    command_ = [this] {
      if (is_part_of_a_job(arguments_.sweep.environment)) {
        throw InputError({"pliant sweep", 0, 0}, "start it without mpirun; --ranks 2 gives each run two ranks");
      }
      arguments_.sweep.results = run_numbers();
      Console console(comm_, Verbosity::normal);
      result_ = sweep_command(arguments_.file, arguments_.overrides(), arguments_.sweep, console);
    };
  });
}

void CommandLine::add_modes() {
  CLI::App* modes =
      app_.add_subcommand("modes", "natural frequencies and mode shapes (eigenmodes), at rest or under load");
  modes->footer(
      examples({"pliant modes beam.yaml", "mpirun -n 2 pliant modes beam.yaml --number 20 --output out/modes",
                "pliant modes string.yaml --set \"time.method=static\"", "pliant modes beam.yaml --near 440"}));
  add_input(*modes);
  add_output(*modes, "directory for modes.csv and the shapes; default: modes in the input's output.directory");
  modes->add_option("--number", arguments_.modes.number, "how many modes, from the lowest frequency on")
      ->check(CLI::Range(1, 10000))
      ->type_name("N")
      ->capture_default_str();
  modes->add_option("--near", arguments_.modes.near, "a frequency [Hz]: the modes nearest to it, not the lowest")
      ->transform(CLI::Validator(
          [](std::string& text) -> std::string {
            try {
              const double frequency = parse_quantity(text, "Hz");
              if (!(frequency > 0.0)) return "a frequency above 0 Hz is expected, not " + text;
              text = fmt::format("{}", frequency);
              return {};
            } catch (const UnitError& error) {
              return error.what();
            }
          },
          ""))
      ->type_name("FREQUENCY");
  modes->add_flag("--unloaded", arguments_.modes.is_unloaded,
                  "about the undeformed state; otherwise, if time.method is static, about the equilibrium under load");
  modes->callback([this] {
    command_ = [this] {
      Console console(comm_, Verbosity::normal);
      arguments_.modes.output = std::exchange(arguments_.output, {});
      result_ = modes_command(comm_, arguments_.file, arguments_.overrides(), arguments_.modes, console);
    };
  });
}

void CommandLine::add_compare() {
  CLI::App* compare =
      app_.add_subcommand("compare", "histories of several runs in common plots, and their differences");
  compare->footer(examples({"pliant compare out/coarse out/fine",
                            "pliant compare out/a out/b out/c --of tip_z,kinetic_energy --output out/abc"}));
  compare
      ->add_option("RUN", arguments_.compare.runs,
                   "directories of results, or files history.csv; the others are compared with the first")
      ->required()
      ->expected(2, 100);
  compare->add_option("--of", arguments_.compare.columns, "columns of the histories; default: all but counts")
      ->delimiter(',')
      ->type_name("COLUMN,...");
  compare->add_option("-o,--output", arguments_.compare.output, "directory for compare.csv and the plots")
      ->capture_default_str()
      ->type_name("DIR");
  compare->callback([this] {
    command_ = [this] {
      if (num_ranks(comm_) > 1) throw InputError({"pliant compare", 0, 0}, "start it without mpirun");
      Console console(comm_, Verbosity::normal);
      result_ = compare_command(arguments_.compare, console);
    };
  });
}

void CommandLine::add_sensitivity() {
  CLI::App* sensitivity =
      app_.add_subcommand("sensitivity", "derivatives of the history of a run by numbers of its input");
  sensitivity->footer(
      examples({"pliant sensitivity finger.yaml --of tip_z --to bodies.0.elasticity.youngs_modulus,bodies.0.density",
                "mpirun -n 2 pliant sensitivity grip.yaml --of tip_x,tip_z --to contact.friction",
                "pliant sensitivity finger.yaml --adjoint weights.csv --fields bodies.0.elasticity.youngs_modulus"}));
  add_input(*sensitivity);
  add_output(*sensitivity, "directory for sensitivity.csv and the plots, or gradient.csv and the fields");
  auto* columns =
      sensitivity->add_option("--of", arguments_.sensitivity.columns, "columns of history.csv, e.g. tip_z,clamp_fx")
          ->delimiter(',')
          ->type_name("COLUMN,...");
  auto* weights = sensitivity
                      ->add_option("--adjoint", arguments_.gradient.weights,
                                   "a CSV file: time, and the derivatives of one number by columns of history.csv. "
                                   "Goes back through the run: the cost hardly depends on how much is asked for")
                      ->type_name("WEIGHTS")
                      ->excludes(columns);
  sensitivity
      ->add_option("--to", arguments_.sensitivity.numbers,
                   "numbers of the input, named as for --set, e.g. bodies.0.density,contact.friction")
      ->delimiter(',')
      ->type_name("KEY,...");
  sensitivity
      ->add_option("--fields", arguments_.gradient.fields,
                   "with --adjoint: constants of which each cell has a value, e.g. "
                   "bodies.0.elasticity.youngs_modulus, bodies.0.density; of each node mesh.nodes (its place: the "
                   "shape), initial.velocity, initial.displacement")
      ->delimiter(',')
      ->type_name("KEY,...")
      ->needs(weights);
  sensitivity
      ->add_option("--kept-steps", arguments_.gradient.kept_steps,
                   "with --adjoint: steps kept in memory; others are computed twice. Default: as many as fit into 1 "
                   "GiB on each rank")
      ->check(CLI::Range(1, 1000000000))
      ->type_name("N")
      ->needs(weights);
  sensitivity->callback([this] { command_ = [this] { differentiate(); }; });
}

void CommandLine::differentiate() {
  const SensitivityOptions& forward = arguments_.sensitivity;
  GradientOptions& adjoint = arguments_.gradient;
  adjoint.numbers = forward.numbers;
  const Location where{"pliant sensitivity", 0, 0};
  if (forward.columns.empty() && adjoint.weights.empty()) {
    throw InputError(where, "either --of COLUMN,... or --adjoint WEIGHTS is needed");
  }
  if (forward.numbers.empty() && adjoint.fields.empty()) {
    throw InputError(where,
                     fmt::format("--to KEY,... {}is needed", adjoint.weights.empty() ? "" : "or --fields KEY,... "));
  }
  Console console(comm_, Verbosity::normal);
  result_ = adjoint.weights.empty()
                ? sensitivity_command(comm_, arguments_.file, arguments_.overrides(), forward, console)
                : gradient_command(comm_, arguments_.file, arguments_.overrides(), adjoint, console);
}

void CommandLine::add_fit() {
  CLI::App* fit = app_.add_subcommand("fit", "fit the constants of a material to measurements");
  fit->footer(examples({"pliant fit rubber.yaml --output out/rubber"}));
  fit->add_option("FIT", arguments_.file, "the fit file (YAML)")->required();
  add_output(*fit, "directory for fit.csv, material.yaml, report.html and the plots; default: out/<name of the file>");
  fit->callback([this] {
    command_ = [this] {
      Console console(comm_, Verbosity::normal);
      result_ = fit_command(comm_, arguments_.file, arguments_.output, console);
    };
  });
}

}  // namespace pliant
