/// The command line's description of itself, for shells and for man.
#pragma once

#include <string>
#include <vector>

namespace CLI {  // NOLINT(readability-identifier-naming): CLI11 calls itself so
class App;
}

namespace pliant {

/// What stands below the options in the help of a command.
std::string examples(const std::vector<std::string>& lines);

/// A script for bash that completes commands, options, choices and files.
std::string bash_completion(const CLI::App& program);

/// The manual page, in roff. `versions`: of the program and its libraries; the first line is used.
std::string man_page(const CLI::App& program, const std::string& versions);

}  // namespace pliant
