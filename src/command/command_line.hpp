/// The commands of the program and their options.
#pragma once

#include "command/commands.hpp"
#include "command/report.hpp"
#include "study/compare.hpp"
#include "study/converge.hpp"
#include "study/gradient.hpp"
#include "study/modes.hpp"
#include "study/sensitivity.hpp"
#include "study/sweep.hpp"

#include <array>
#include <functional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace pliant {

/// Reads the command line and runs the command that it names. All methods are collective.
class CommandLine {
 public:
  /// `of_sweep`: the arguments that a sweep passes to its runs, options of PETSc included. Throws InputError for words
  /// among them that belong to no option.
  CommandLine(MPI_Comm comm, const SweepOptions& of_sweep);
  CommandLine(const CommandLine&) = delete;  // callbacks refer to the object
  CommandLine& operator=(const CommandLine&) = delete;

  /// The exit code of the command, or that after help, version or an error in the command line.
  ExitCode operator()(int argc, const char* const* argv);

 private:
  /// In the place of a file's name: the page of an input has the input's name.
  static constexpr const char* page_by_input = "INPUT.html";
  struct Arguments {
    std::string file;
    std::vector<std::string> settings;
    std::string output;
    std::array<double, 2> stretches{0.6, 2.0};
    bool quiet = false;
    bool markdown = false;
    bool is_of_fit = false;
    bool library = false;  ///< of measured materials
    bool continues = false;
    std::string page;  ///< of `check`, or page_by_input
    StudyOptions study;
    Conversion conversion;
    SweepOptions sweep;
    std::vector<std::string> results;  ///< of a study: --result
    CompareOptions compare;
    SensitivityOptions sensitivity;
    GradientOptions gradient;
    ModesOptions modes;
    ReportOptions report;
    std::string refine;
    std::vector<std::string> words;
    bool accepts_any_order = false;

    /// Throws InputError for a text that is not KEY.PATH=VALUE.
    std::vector<Override> overrides() const;
    /// The file of the page; empty: none is wanted.
    std::string page_of_check() const;
  };

  void add_input(CLI::App& to);
  void add_output(CLI::App& to, const std::string& what);
  void add_results(CLI::App& to, const std::string& what);
  /// What --result asks for. Throws InputError.
  std::vector<RunNumber> run_numbers() const;
  /// A command that prints a text.
  CLI::App& add_text(const char* name, const char* what, std::function<std::string()> text);
  void add_run();
  void add_resume();
  void add_info();
  void add_report();
  struct PythonArgument {
    const char *name, *what;
  };
  /// A command that Python code carries out, which reads the options too.
  CLI::App& add_in_python(const char* name, const char* what, const PythonArgument& argument);
  void add_render();
  void add_plot();
  void add_convert();
  void add_check();
  void add_converge();
  void add_modes();
  void add_sweep();
  void add_compare();
  void add_sensitivity();
  void differentiate();
  void add_fit();
  void add_mesh();
  void add_methods();
  void add_materials();
  void add_schema();
  /// Help, shell completion and the manual page.
  void add_help();

  MPI_Comm comm_;
  bool speaks_;
  Arguments arguments_;
  CLI::App app_;
  std::vector<std::string> words_;  // as they were typed
  std::function<void()> command_;   // that was named
  ExitCode result_ = ExitCode::done;
};

}  // namespace pliant
