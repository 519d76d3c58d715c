/// `pliant render`, `pliant plot` and `pliant convert`: the program starts their Python code.
#pragma once

#include "base/error.hpp"
#include "study/processes.hpp"

#include <string>
#include <vector>

namespace pliant {

/// Runs pliant/start.py, which lies in ../lib/python3/dist-packages from the program's folder, with the words
/// of the command line that follow `command`; it writes to the terminal itself. The interpreter is the environment
/// variable PLIANT_PYTHON, else /usr/bin/python3, whose modules are Debian's. Returns its exit code. Throws InputError
/// if the interpreter is missing, FileError if the code is missing. Not collective.
ExitCode python_command(const std::string& command, const std::vector<std::string>& words,
                        const Environment& environment);

}  // namespace pliant
