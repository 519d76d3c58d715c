#include "study/earlier_runs.hpp"

#include "input/input.hpp"

#include <set>
#include <string>

#include <fmt/format.h>

namespace pliant {
namespace {

namespace fs = std::filesystem;

/// NN_KEY=VALUE, with what a sweep records of a run. Directories of that name without it are the user's.
bool is_run_of_a_sweep(const fs::path& directory) {
  const std::string name = directory.filename().string();
  const std::size_t digits = name.find_first_not_of("0123456789");
  if (digits == std::string::npos || digits < 2 || name[digits] != '_' || name.find('=') == std::string::npos)
    return false;
  std::error_code ignored;
  return fs::is_directory(directory, ignored) && fs::exists(directory / "log.txt", ignored);
}

}  // namespace

void refuse_other_runs(const fs::path& directory, const std::vector<fs::path>& runs) {
  std::set<std::string> names, others;
  for (const fs::path& run : runs) names.insert(run.filename().string());
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(directory, ignored)) {
    const std::string name = entry.path().filename().string();
    if (!names.contains(name) && is_run_of_a_sweep(entry.path())) others.insert(name);
  }
  if (others.empty()) return;
  throw InputError(
      {directory.string(), 0, 0},
      fmt::format("it has {} of another sweep, such as {}: name another directory with --output, or remove "
                  "this one",
                  others.size() == 1 ? "a run" : fmt::format("{} runs", others.size()), *others.begin()));
}

}  // namespace pliant
