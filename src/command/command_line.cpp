#include "command/command_line.hpp"

#include "base/text.hpp"
#include "command/command_help.hpp"
#include "command/material_reference.hpp"
#include "command/resume.hpp"
#include "input/reference.hpp"
#include "material/library.hpp"
#include "petsc/session.hpp"
#include "run/version.hpp"
#include "study/fit_input.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace pliant {
namespace {

/// Does not show options as lists that take one value each time they are given.
class HelpFormatter : public CLI::Formatter {
 public:
  std::string make_option_opts(const CLI::Option* option) const override {
    constexpr std::string_view list = " ...";
    std::string text = CLI::Formatter::make_option_opts(option);
    const auto at = text.find(list);
    return option->get_allow_extra_args() || at == std::string::npos ? text : text.erase(at, list.size());
  }
};

std::string no_command(const std::string& word, const CLI::App& among, const std::string& instead = "") {
  std::vector<std::string> names;
  for (const CLI::App* sub : among.get_subcommands({})) names.push_back(sub->get_name());
  std::string meant = instead.empty() ? did_you_mean(word, names) : instead;
  if (meant.empty() && names.size() < 4) meant = "; its commands are: " + joined(names);
  return fmt::format("there is no command '{}'{}", word, meant);
}

/// The first word that the command does not take: an option, or else an argument; CLI11 lists all of them backwards.
std::string no_place_for(const std::vector<std::string>& words, const CLI::App& command) {
  const auto option = std::ranges::find_if(words, [](const std::string& word) { return word.starts_with('-'); });
  if (option == words.end() && !command.get_subcommands({}).empty()) {
    const std::string& word = words.front();
    const bool is_law = std::ranges::find(elastic_laws(), word, &LawInfo::name) != elastic_laws().end();
    const bool can_be_plotted = command.get_name() == "materials" && (is_law || find_material(word) != nullptr);
    return no_command(word, command,
                      can_be_plotted ? "; to plot a law or a material: pliant materials plot " + word : "");
  }
  if (option == words.end()) {
    const auto repeats = [](const CLI::Option* one) { return one->count() > 0 && one->get_expected_max() > 1; };
    const auto given = command.get_options(repeats);
    const std::string how =
        command.get_name() == "plot" ? "; columns are given by --of " + words.front()
        : given.empty()              ? ""
                        : fmt::format("; several values of {0} are given as {0} {1} {0} {2}", given.front()->get_name(),
                                      given.front()->results().back(), words.front());
    return fmt::format("it takes no argument '{}'{}", words.front(), how);
  }
  const std::string name = option->substr(0, option->find('='));
  if (name == "-n" || name == "-np") {
    const bool has_number = option + 1 != words.end() && parse_number(*(option + 1)).has_value();
    return fmt::format("it has no option '{0}'; on several ranks: mpirun -n {1} pliant {2} INPUT", name,
                       has_number ? *(option + 1) : "2", command.get_name());
  }
  std::vector<std::string> known;
  for (const CLI::Option* of : command.get_options()) {
    for (const std::string& long_name : of->get_lnames()) known.push_back("--" + long_name);
  }
  std::string meant = did_you_mean(name, known);
  if (meant.empty() && known.size() > 2 && known.size() < 9) meant = "; its options are: " + joined(known);
  return fmt::format("it has no option '{}'{}", name, meant);
}

/// What CLI11 says, and what most likely was meant.
std::string explained(const CLI::ParseError& error, const CLI::App& app, int argc, const char* const* argv) {
  std::string command = "pliant";
  const CLI::App* at = &app;
  for (; !at->get_subcommands().empty(); at = at->get_subcommands().front()) {
    command += " " + at->get_subcommands().front()->get_name();
  }
  const std::vector<std::string> words(argv + 1, argv + argc);
  std::string text = error.what();
  if (at == &app && !words.empty() && !words[0].starts_with('-')) {
    std::error_code ignored;
    const bool is_file = std::filesystem::exists(words[0], ignored);
    text = no_command(words[0], app, is_file ? "; to run an input: pliant run " + words[0] : "");
  } else if (const auto left = at->remaining(); !left.empty()) {
    text = no_place_for(left, *at);
  }
  const auto is_setting = [](const std::string& word) {
    return !word.starts_with('-') && word.find('=') != std::string::npos;
  };
  const auto setting = std::ranges::find_if(words, is_setting);
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ExtrasError) && setting != words.end() &&
      at->get_option_no_throw("--set") != nullptr && text.find("--set") == std::string::npos) {
    text += fmt::format("; values of the input are set by --set {}", *setting);
  }
  return fmt::format("{}: {}; see {} --help", command, text, command);
}

/// The help of the command that the words name, one within the other; of the program if there are none.
std::string help_text(CLI::App& app, std::vector<std::string> words) {
  app.clear();  // what was parsed, of which the help would be
  const CLI::App* at = &app;
  std::string above;
  for (const std::string& word : words) {
    const auto commands = at->get_subcommands({});
    const auto found = std::ranges::find(commands, word, [](const CLI::App* sub) { return sub->get_name(); });
    if (found == commands.end()) {
      throw InputError({"pliant help", 0, 0}, no_command(word, *at));
    }
    above += (above.empty() ? "" : " ") + at->get_name();
    at = *found;
  }
  return at->help(above);
}

/// PETSc passes over words that belong to no option.
void require_options(const std::vector<std::string>& petsc_options) {
  const auto is_option = [](const std::string& word) {
    return word.size() > 1 && word[0] == '-' &&
           (std::isalpha(static_cast<unsigned char>(word[1])) != 0 || word[1] == '-');
  };
  for (std::size_t i = 0; i < petsc_options.size(); ++i) {
    if (is_option(petsc_options[i]) || (i > 0 && is_option(petsc_options[i - 1]))) continue;
    throw InputError(
        {"PETSc options", 0, 0},
        fmt::format("'{}' belongs to no option; they begin with '-', and have one value at most", petsc_options[i]));
  }
}

}  // namespace

std::string CommandLine::Arguments::page_of_check() const {
  return page == page_by_input ? std::filesystem::path(file).stem().string() + ".html" : page;
}

std::vector<Override> CommandLine::Arguments::overrides() const {
  std::vector<Override> result;
  for (const auto& setting : settings) {
    const auto equals = setting.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw InputError({"--set " + setting, 0, 0}, "expected KEY.PATH=VALUE, e.g. --set time.step=\"5 ms\"");
    }
    result.push_back({std::string(trimmed(setting.substr(0, equals))), setting.substr(equals + 1)});
  }
  if (!output.empty()) result.push_back({"output.directory", output});
  return result;
}

CommandLine::CommandLine(MPI_Comm comm, const SweepOptions& of_sweep)
    : comm_(comm),
      speaks_(rank(comm) == 0),
      app_("Finite-element dynamics of soft bodies. Run in parallel with mpirun -n N pliant run INPUT.yaml", "pliant") {
  require_options(of_sweep.petsc_options);
  arguments_.sweep = of_sweep;
  app_.footer(
      "pliant COMMAND --help shows a command's options and examples.\nWhat stands after -- goes to PETSc, e.g. pliant "
      "run beam.yaml -- -snes_monitor -log_view\n\nThe documents, inputs and meshes of an installed program are in "
      "share/pliant, such as /usr/share/pliant/docs/index.md.");
  app_.set_version_flag("--version", version_text);
  app_.require_subcommand(1);
  app_.formatter(std::make_shared<HelpFormatter>());  // before commands, which take it over
  add_run();
  add_resume();
  add_info();
  add_report();
  add_render();
  add_plot();
  add_check();
  add_converge();
  add_modes();
  add_sweep();
  add_compare();
  add_sensitivity();
  add_fit();
  add_mesh();
  add_convert();
  add_methods();
  add_materials();
  add_schema();
  add_help();
}

ExitCode CommandLine::operator()(int argc, const char* const* argv) {
  words_.assign(argv + 1, argv + argc);
  try {
    app_.parse(argc, argv);
  } catch (const CLI::Success& asked) {
    if (speaks_) app_.exit(asked);
    return ExitCode::done;
  } catch (const CLI::ParseError& error) {
    if (speaks_ && argc == 1) fmt::print("{}\n", app_.help());
    if (speaks_) fmt::print(stderr, "{}\n", explained(error, app_, argc, argv));
    return ExitCode::input;
  }
  command_();
  return result_;
}

void CommandLine::add_input(CLI::App& to) {
  to.add_option("INPUT", arguments_.file, "the input file (YAML)")->required();
  to.add_option("--set", arguments_.settings, "KEY.PATH=VALUE: replaces a value of the input; may be repeated")
      ->allow_extra_args(false);
}

void CommandLine::add_output(CLI::App& to, const std::string& what) {
  to.add_option("-o,--output", arguments_.output, what)->check([](const std::string& name) {
    return std::string(name.empty() ? "the name is empty" : "");
  });
}

CLI::App& CommandLine::add_text(const char* name, const char* what, std::function<std::string()> text) {
  CLI::App* sub = app_.add_subcommand(name, what);
  sub->callback([this, sub, text = std::move(text)] {
    if (!sub->get_subcommands().empty()) return;  // theirs ran already
    command_ = [this, text] {
      if (speaks_) fmt::print("{}", text());
    };
  });
  return *sub;
}

void CommandLine::add_run() {
  CLI::App* run = app_.add_subcommand("run", "run a simulation");
  run->footer(
      examples({"pliant run beam.yaml", "mpirun -n 4 pliant run beam.yaml --output out/fine --set mesh.refine=1",
                "pliant run beam.yaml --set time.step=\"5 ms\" -- -log_view", "pliant run beam.yaml --continue"}));
  add_input(*run);
  add_output(*run, "directory for the results");
  run->add_flag("--continue", arguments_.continues,
                "continue the run in the output directory from its newest checkpoint; start it if there is none");
  run->add_flag("--quiet", arguments_.quiet, "print warnings and errors only");
  run->callback([this] {
    command_ = [this] {
      Console console(comm_, arguments_.quiet ? Verbosity::quiet : Verbosity::normal);
      const auto command_of = arguments_.continues ? continue_command : run_command;
      result_ = command_of(comm_, arguments_.file, arguments_.overrides(), console);
    };
  });
}

void CommandLine::add_resume() {
  CLI::App* resume = app_.add_subcommand("resume", "continue from a checkpoint");
  resume->footer(examples(
      {"pliant resume out/beam", "mpirun -n 2 pliant resume out/beam/checkpoint-000100.h5 --set time.end=\"4 s\""}));
  resume->add_option("CHECKPOINT", arguments_.file, "the checkpoint, or a directory with checkpoints: its newest one")
      ->required();
  resume
      ->add_option("--set", arguments_.settings,
                   "KEY.PATH=VALUE: replaces a value of the input, e.g. time.end; may be repeated")
      ->allow_extra_args(false);
  add_output(*resume, "directory for the results; default: that of the checkpoint");
  resume->add_flag("--quiet", arguments_.quiet, "print warnings and errors only");
  resume->callback([this] {
    command_ = [this] {
      Console console(comm_, arguments_.quiet ? Verbosity::quiet : Verbosity::normal);
      result_ = resume_command(comm_, arguments_.file, arguments_.overrides(), console);
    };
  });
}

void CommandLine::add_info() {
  CLI::App* info = app_.add_subcommand("info", "describe a checkpoint or a result");
  info->footer(examples({"pliant info out/beam", "pliant info out/beam/checkpoint-000100.h5"}));
  info->add_option("FILE", arguments_.file, "checkpoint-*.h5, result.h5 or the directory of a result")->required();
  info->callback([this] {
    command_ = [this] {
      const std::string text = info_text(comm_, arguments_.file);
      if (speaks_) fmt::print("{}", text);
    };
  });
}

void CommandLine::add_report() {
  CLI::App* report = app_.add_subcommand("report", "write an HTML page that plays a result and plots its history");
  report->footer(examples({"pliant report out/beam", "pliant report out/beam --output beam.html --size 10",
                           "pliant report out/beam --watch", "pliant report out/coarse out/fine"}));
  report->add_option("RESULT", arguments_.report.place, "directory of a result, its result.h5 or result.xdmf")
      ->required();
  report->add_option("OTHER", arguments_.report.other,
                     "another result, which is shown next to it with the same camera and time");
  report->add_option("-o,--output", arguments_.report.output,
                     "the file; default: report.html next to the result, of two results comparison.html");
  report
      ->add_option("--size", arguments_.report.megabytes,
                   "largest size of the page in megabytes; frames are left out if it would be larger")
      ->check(CLI::PositiveNumber)
      ->type_name("MB")
      ->capture_default_str();
  report
      ->add_option("--watch", arguments_.report.watch,
                   "renew the page so often while the run is active; an open page follows by itself")
      ->expected(0, 1)
      ->default_str("5")
      ->check(CLI::Range(0.1, 3600.0))
      ->type_name("SECONDS");
  report->callback([this] {
    command_ = [this] {
      Console console(comm_, Verbosity::normal);
      report_command(comm_, arguments_.report, console);
    };
  });
}

void CommandLine::add_check() {
  CLI::App* check = app_.add_subcommand("check", "read the input, mesh and partition it, and report; solves nothing");
  check->footer(examples({"pliant check beam.yaml", "mpirun -n 8 pliant check beam.yaml --set element=P2",
                          "pliant check beam.yaml --html"}));
  add_input(*check);
  check
      ->add_option("--html", arguments_.page,
                   "show the model on a page of HTML: bodies, groups, constraints, loads, contact, worst elements")
      ->expected(0, 1)
      ->default_str(CommandLine::page_by_input)
      ->type_name("FILE");
  check->callback([this] {
    command_ = [this] {
      Console console(comm_, Verbosity::normal);
      result_ = check_command(comm_, arguments_.file, arguments_.overrides(), arguments_.page_of_check(), console);
    };
  });
}

void CommandLine::add_converge() {
  CLI::App* converge =
      app_.add_subcommand("converge", "convergence study: finer and finer steps, meshes or tolerances");
  converge->footer(examples({"pliant converge beam.yaml --in time --levels 4 --methods bdf2,dirk33",
                             "pliant converge beam.yaml --in space --levels 3 --no-check --result \"last(tip_z)\""}));
  add_input(*converge);
  add_output(*converge, "directory for convergence.csv and the plots");
  converge
      ->add_option("--in", arguments_.refine,
                   "what is refined: time (steps), space (the mesh, uniformly) or tolerance (of adaptive steps)")
      ->required()
      ->check(CLI::IsMember({"time", "space", "tolerance"}))
      ->type_name("time|space|tolerance");
  converge->add_option("--levels", arguments_.study.levels, "how many; each halves steps or mesh size")
      ->check(CLI::Range(2, 12))
      ->type_name("N")
      ->capture_default_str();
  converge
      ->add_option("--methods", arguments_.study.methods,
                   "methods to compare, e.g. bdf2,dirk22; all; default: the input's")
      ->delimiter(',')
      ->type_name("NAME,...");
  add_results(*converge, "each level, with its error and order");
  converge->add_flag("--no-check", arguments_.accepts_any_order,
                     "do not fail where an observed order falls short of the theoretical one by more than 0.3");
  converge->callback([this] {
    command_ = [this] {
      Console console(comm_, Verbosity::normal);
      arguments_.study.refine = arguments_.refine == "space"       ? Refine::space
                                : arguments_.refine == "tolerance" ? Refine::tolerance
                                                                   : Refine::time;
      arguments_.study.checks_orders = !arguments_.accepts_any_order;
      arguments_.study.results = run_numbers();
      result_ = converge_command(comm_, arguments_.file, arguments_.overrides(), arguments_.study, console);
    };
  });
}

void CommandLine::add_mesh() {
  CLI::App* mesh = app_.add_subcommand("mesh", "work on a mesh alone")->require_subcommand(1);
  mesh->footer(examples({"pliant mesh convert part.step part.h5 --size \"2 mm\" --scale 0.001"}));
  CLI::App* convert =
      mesh->add_subcommand("convert", "write a mesh as HDF5, which ranks read in parallel: needed for large meshes");
  convert->footer(examples({"pliant mesh convert part.step part.h5 --size \"2 mm\" --scale 0.001"}));
  convert
      ->add_option("MESH", arguments_.conversion.from, "what mesh.file of an input may name (.msh, .geo, .step, ...)")
      ->required();
  convert->add_option("OUTPUT", arguments_.conversion.to, "the file to write, NAME.h5")->required();
  convert->add_option("--size", arguments_.conversion.size, "target element size of geometry, e.g. \"2 mm\"");
  convert->add_option("--scale", arguments_.conversion.scale, "coordinates are multiplied by it")
      ->capture_default_str();
  convert->add_flag("--allow-commands", arguments_.conversion.allows_commands,
                    "let a .geo script run programs and write files: only for files you trust");
  convert->callback([this] {
    command_ = [this] {
      Console console(comm_, Verbosity::normal);
      convert_mesh_command(comm_, arguments_.conversion, console);
    };
  });
}

void CommandLine::add_methods() {
  add_text("methods", "list the time integration methods", methods_text).footer(examples({"pliant methods"}));
}

void CommandLine::add_materials() {
  CLI::App& materials = add_text("materials", "list the material laws, or plot one", [this] {
    if (arguments_.library) return library_text();
    return arguments_.markdown ? material_reference() : materials_text();
  });
  materials.add_flag("--library", arguments_.library, "list the measured materials with their sources instead");
  materials.add_flag("--markdown", arguments_.markdown, "print the reference of the laws in Markdown instead");
  materials.footer(
      examples({"pliant materials", "pliant materials --library", "pliant materials plot yeoh --set c10=0.2MPa"}));
  CLI::App* plot =
      materials.add_subcommand("plot", "draw stress over stretch of an elastic law or a measured material");
  plot->footer(examples({"pliant materials plot yeoh", "pliant materials plot ecoflex-00-30 --stretch 1 5",
                         "pliant materials plot ogden --set mu1=0.3MPa --stretch 0.5 3 --output ogden.svg"}));
  plot->add_option("LAW", arguments_.file, "name of the law, or of a material of the library")->required();
  plot->add_option("--set", arguments_.settings,
                   "KEY=VALUE: a parameter of the law; the others are typical ones; may be repeated")
      ->allow_extra_args(false);
  plot->add_option("--stretch", arguments_.stretches, "the lowest and the highest stretch")->capture_default_str();
  plot->add_option("-o,--output", arguments_.output, "the SVG file; default: LAW.svg");
  plot->callback([this] {
    command_ = [this] {
      plot_material_command(comm_, arguments_.file, arguments_.settings, arguments_.stretches, arguments_.output);
    };
  });
}

void CommandLine::add_schema() {
  CLI::App& schema = add_text("schema", "print the JSON schema of the input", [this] {
    if (arguments_.is_of_fit) return arguments_.markdown ? fit_reference() : fit_schema();
    return arguments_.markdown ? input_reference() : json_schema();
  });
  schema.add_flag("--fit", arguments_.is_of_fit, "of the file that pliant fit reads, instead of the input");
  schema.add_flag("--markdown", arguments_.markdown, "print the reference of the input in Markdown instead");
  schema.footer(examples({"pliant schema > input.schema.json", "pliant schema --markdown > input.md"}));
}

void CommandLine::add_help() {
  CLI::App& help = add_text("help", "show the help of a command", [this] { return help_text(app_, arguments_.words); });
  help.add_option("COMMAND", arguments_.words, "the command; default: this program");
  help.footer(examples({"pliant help run", "pliant help mesh convert"}));

  add_text("completion", "print a script that lets bash complete commands, options and files", [this] {
    return bash_completion(app_);
  }).footer(examples({"source <(pliant completion)"}));
  add_text("man", "print the manual page", [this] {
    return man_page(app_, version_text());
  }).footer(examples({"pliant man | man -l -"}));
}

}  // namespace pliant
