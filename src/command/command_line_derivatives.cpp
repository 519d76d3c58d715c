// The commands that differentiate runs and fit numbers.
#include "command/command_help.hpp"
#include "command/command_line.hpp"
#include "study/fit.hpp"

#include <fmt/format.h>

namespace pliant {

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
                   "bodies.0.elasticity.youngs_modulus; initial.velocity, initial.displacement of each node")
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
