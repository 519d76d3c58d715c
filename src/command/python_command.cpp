#include "command/python_command.hpp"

#include "run/signals.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>

#include <fmt/format.h>

namespace pliant {
namespace {

namespace fs = std::filesystem;

std::string interpreter() {
  const char* named = std::getenv("PLIANT_PYTHON");
  return named != nullptr && *named != '\0' ? named : "/usr/bin/python3";
}

}  // namespace

ExitCode python_command(const std::string& command, const std::vector<std::string>& words,
                        const Environment& environment) {
  const fs::path program = fs::read_symlink("/proc/self/exe");
  const fs::path packages = program.parent_path().parent_path() / "lib/python3/dist-packages";
  const fs::path script = packages / "pliant/start.py";
  if (!fs::exists(script)) {
    throw FileError(fmt::format(
        "pliant {}: its Python code is missing: '{}' does not exist; configure and build, or install, again", command,
        script.string()));
  }
  Program python{{interpreter(), "-B", script.string(), command}, {}};
  python.arguments.insert(python.arguments.end(), words.begin(), words.end());
  const int code = run_all({python}, environment, 1, [](std::size_t, const Ended&) {}).front().code;
  constexpr int not_started = 127, killed = 128;
  if (code == not_started) {
    throw InputError({"pliant " + command, 0, 0},
                     fmt::format("'{}' could not be started: install the package python3, or name another Python in "
                                 "the environment variable PLIANT_PYTHON",
                                 interpreter()));
  }
  constexpr std::array passed_on{ExitCode::done, ExitCode::input, ExitCode::file};
  const auto same = std::ranges::find(passed_on, static_cast<ExitCode>(code));
  if (same != passed_on.end()) return *same;
  if (std::ranges::find(stop_signals, code - killed) != stop_signals.end()) return ExitCode::interrupted;
  fmt::print(stderr, "pliant {}: its Python code failed ({})\n", command,
             code > killed ? fmt::format("signal {}", code - killed) : fmt::format("exit code {}", code));
  return ExitCode::unexpected;
}

}  // namespace pliant
