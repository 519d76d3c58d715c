#include "command/command_help.hpp"

#include <algorithm>
#include <array>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace pliant {
namespace {

struct Command {
  std::string path;  // "mesh convert"; empty: the program itself
  const CLI::App* app;
};

/// The program, its commands, theirs.
std::vector<Command> commands_of(const CLI::App& app, const std::string& path = "") {
  std::vector<Command> commands{{path, &app}};
  for (const CLI::App* sub : app.get_subcommands({})) {
    const auto below = commands_of(*sub, path.empty() ? sub->get_name() : path + " " + sub->get_name());
    commands.insert(commands.end(), below.begin(), below.end());
  }
  return commands;
}

std::vector<const CLI::Option*> options_of(const CLI::App& app, bool positional) {
  std::vector<const CLI::Option*> options;
  for (const CLI::Option* option : app.get_options({})) {
    if (option->get_positional() == positional) options.push_back(option);
  }
  return options;
}

/// "-h", "--help"
std::vector<std::string> names_of(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const auto& name : option.get_snames()) names.push_back("-" + name);
  for (const auto& name : option.get_lnames()) names.push_back("--" + name);
  return names;
}

bool takes_a_value(const CLI::Option& option) {
  return option.get_items_expected_max() > 0;
}

/// Without what checks of the value have added to it: "N" of "N:INT in [2 - 12]".
std::string type_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  return type.substr(0, type.find(':'));
}

/// "time", "space" of a type called "time|space"; nothing else.
std::vector<std::string> choices_of(const CLI::Option& option) {
  std::vector<std::string> choices;
  const std::string type = type_of(option);
  if (type.find('|') == std::string::npos) return choices;
  std::istringstream words(type);
  for (std::string word; std::getline(words, word, '|');) choices.push_back(word);
  return choices;
}

/// Files that fit an argument, as a pattern of bash.
std::string pattern_of(const CLI::Option& argument) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 6> patterns{{{"INPUT", "*.@(yaml|yml)"},
                                                                                   {"FIT", "*.@(yaml|yml)"},
                                                                                   {"CHECKPOINT", "*.h5"},
                                                                                   {"FILE", "*.h5"},
                                                                                   {"MODEL", "*.@(inp|feb)"},
                                                                                   {"RESULT", "*.@(h5|xdmf)"}}};
  const std::string name = argument.get_name(/*positional=*/true);
  const auto* found = std::ranges::find(patterns, name, &std::pair<std::string_view, std::string_view>::first);
  return std::string(found == patterns.end() ? "*" : found->second);
}

/// Hyphens and lines that begin like a request mean something to roff.
std::string roff(std::string_view text) {
  std::string result;
  bool is_start = true;
  for (const char c : text) {
    if (is_start && (c == '.' || c == '\'')) result += "\\&";
    if (c == '\\') {
      result += "\\e";
    } else if (c == '-') {
      result += "\\-";
    } else {
      result += c;
    }
    is_start = c == '\n';
  }
  return result;
}

/// Branches of the script's case statements.
struct BashCases {
  std::string paths;                // which command a word leads to
  std::string commands;             // what a command offers
  std::string values;               // what an option offers
  std::vector<std::string> taking;  // options that take a value

  void add(const Command& command) {
    const auto& [path, app] = command;
    if (!path.empty()) {
      const auto blank = path.rfind(' ');
      paths += fmt::format("      '{} {}') path='{}' ;;\n", blank == std::string::npos ? "" : path.substr(0, blank),
                           app->get_name(), path);
    }
    std::vector<std::string> subcommands, options;
    for (const CLI::App* sub : app->get_subcommands({})) subcommands.push_back(sub->get_name());
    for (const CLI::Option* option : options_of(*app, false)) {
      for (const auto& name : names_of(*option)) options.push_back(name);
      if (takes_a_value(*option)) add(path, *option);
    }
    const auto arguments = options_of(*app, true);
    commands += fmt::format("    '{}') options='{}' words='{}' files='{}' ;;\n", path, fmt::join(options, " "),
                            fmt::join(subcommands, " "), arguments.empty() ? "" : pattern_of(*arguments.front()));
  }

 private:
  void add(const std::string& path, const CLI::Option& option) {
    for (const auto& name : names_of(option)) {
      if (std::ranges::find(taking, name) == taking.end()) taking.push_back(name);
    }
    const auto choices = choices_of(option);
    std::vector<std::string> places;
    for (const auto& name : names_of(option)) places.push_back(fmt::format("'{} {}'", path, name));
    const std::string place = fmt::format("    {}) ", fmt::join(places, " | "));
    if (!choices.empty()) values += place + fmt::format("words='{}' ;;\n", fmt::join(choices, " "));
    if (option.check_lname("output")) values += place + "files='*' ;;\n";
  }
};

std::string synopsis_of(const Command& command) {
  std::string text = command.path;
  for (const CLI::Option* argument : options_of(*command.app, true)) text += " " + argument->get_name(true);
  if (!command.app->get_subcommands({}).empty()) text += " COMMAND";
  return text;
}

std::string option_in_man(const CLI::Option& option) {
  std::string heading;
  for (const auto& name : names_of(option)) heading += (heading.empty() ? "" : ", ") + name;
  if (heading.empty()) heading = option.get_name(/*positional=*/true);
  std::string text = ".TP\n.B " + roff(heading);
  if (takes_a_value(option) && !option.get_positional()) text += " \\fI" + roff(type_of(option)) + "\\fR";
  text += "\n" + roff(option.get_description());
  if (!option.get_default_str().empty()) text += roff(" (default: " + option.get_default_str() + ")");
  return text + "\n";
}

}  // namespace

std::string examples(const std::vector<std::string>& lines) {
  return fmt::format("Examples:\n  {}", fmt::join(lines, "\n  "));
}

std::string bash_completion(const CLI::App& program) {
  BashCases cases;
  for (const auto& command : commands_of(program)) cases.add(command);
  return fmt::format(R"(# Completion of pliant for bash, as `pliant completion` prints it.
_pliant() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} previous=${{COMP_WORDS[COMP_CWORD - 1]}} path='' options words files i
  for ((i = 1; i < COMP_CWORD; ++i)); do
    [[ ${{COMP_WORDS[i]}} != -- ]] || return  # PETSc's options
    case "$path ${{COMP_WORDS[i]}}" in
{}    esac
  done
  case $path in
{}  esac
  # What follows an option that takes a value is that.
  case $previous in
    {}) options='' words='' files='' ;;
  esac
  case "$path $previous" in
{}  esac
  if [[ $current == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$options" -- "$current")
  elif [[ $words ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
  elif [[ $files ]]; then
    mapfile -t COMPREPLY < <({{ shopt -s extglob; compgen -f -X "!$files" -- "$current"; compgen -d -- "$current"; }} | sort -u)
    compopt -o filenames 2>/dev/null
  fi
}}
complete -F _pliant pliant
)",
                     cases.paths, cases.commands, fmt::join(cases.taking, " | "), cases.values);
}

std::string man_page(const CLI::App& program, const std::string& versions) {
  std::string text = fmt::format(".TH PLIANT 1 \"\" \"{}\"\n", versions.substr(0, versions.find('\n')));
  text += ".SH NAME\npliant \\- finite\\-element dynamics of soft bodies\n";
  text +=
      ".SH SYNOPSIS\n.B pliant\n.I COMMAND\n[\\fIARGUMENT\\fR ...] [\\fB\\-\\-\\fR \\fIPETSC\\-OPTION\\fR ...]\n.br\n";
  text += ".B mpirun \\-n\n.I N\n.B pliant run\n.I INPUT\n";
  text += ".SH DESCRIPTION\n" + roff(program.get_description()) + ".\n.PP\n" + roff(program.get_footer()) + "\n";
  text += ".SH OPTIONS\n";
  for (const CLI::Option* option : options_of(program, false)) text += option_in_man(*option);
  text += ".SH COMMANDS\n";
  for (const auto& command : commands_of(program)) {
    if (command.path.empty()) continue;
    text += fmt::format(".SS \"pliant {}\"\n{}\n", roff(synopsis_of(command)), roff(command.app->get_description()));
    for (const bool positional : {true, false}) {
      for (const CLI::Option* option : options_of(*command.app, positional)) {
        if (option != command.app->get_help_ptr()) text += option_in_man(*option);
      }
    }
    // A command without a footer has that of the program.
    const std::string footer = command.app->get_footer();
    if (!footer.empty() && footer != program.get_footer()) text += ".PP\n.nf\n" + roff(footer) + "\n.fi\n";
  }
  constexpr std::array<std::pair<int, std::string_view>, 7> codes{
      {{0, "done"},
       {1, "a convergence study or a sweep did not pass, or a fit did not converge"},
       {2, "the input or the command line is wrong"},
       {3, "the solve failed after every retry; the last good state is on disk"},
       {4, "a file could not be read or written"},
       {70, "an unexpected failure, such as too little memory, or a bug in Pliant"},
       {130, "interrupted; a run has written a checkpoint"}}};
  text += ".SH EXIT STATUS\n";
  for (const auto& [code, meaning] : codes) text += fmt::format(".TP\n.B {}\n{}\n", code, roff(meaning));
  return text + ".SH SEE ALSO\n.BR mpirun (1)\n";
}

}  // namespace pliant
