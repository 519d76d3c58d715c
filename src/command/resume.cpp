#include "command/resume.hpp"

#include "base/file.hpp"
#include "base/text.hpp"
#include "io/result_info.hpp"
#include "io/result_reader.hpp"
#include "petsc/collective.hpp"
#include "petsc/hdf5.hpp"
#include "petsc/session.hpp"
#include "run/checkpoints.hpp"
#include "run/run.hpp"
#include "run/summary.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <ranges>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

namespace pliant {
namespace {

namespace fs = std::filesystem;

/// Settings that do not concern the state: a key, with those below it, and how to take its value over.
struct Changeable {
  std::string_view key;
  void (*take)(Config& to, const Config& from);
};

void take_end(Config& to, const Config& from) {
  if (analysis_of(to) == Analysis::static_equilibrium && to.time.end != from.time.end) {
    throw InputError({"time.end", 0, 0},
                     "in a static analysis this is the time at which formulas of loads are evaluated, and cannot "
                     "change when a run is resumed; start a new run with `pliant run`");
  }
  to.time.end = from.time.end;
}

void take_path(Config& to, const Config& from) {
  if (!to.time.path && from.time.path) {
    throw InputError(
        from.time.path->where,
        "the run that is resumed follows no path, and cannot begin one; start a new run with `pliant run`");
  }
  if (to.time.path && !from.time.path) {
    throw InputError({"time.path", 0, 0},
                     "the run that is resumed follows a path, and cannot leave it; start a new run with `pliant run`");
  }
  to.time.path = from.time.path;
}

constexpr std::array<Changeable, 8> changeable{
    {{"time.end", take_end},
     {"time.step", [](Config& to, const Config& from) { to.time.step = from.time.step; }},
     {"time.min_step", [](Config& to, const Config& from) { to.time.min_step = from.time.min_step; }},
     {"time.path", take_path},
     {"solver", [](Config& to, const Config& from) { to.solver = from.solver; }},
     {"output", [](Config& to, const Config& from) { to.output = from.output; }},
     {"checkpoint", [](Config& to, const Config& from) { to.checkpoint = from.checkpoint; }},
     {"title", [](Config& to, const Config& from) { to.title = from.title; }}}};

void check_changes(const std::vector<Override>& overrides) {
  std::vector<Diagnostic> refused;
  for (const auto& change : overrides) {
    const bool may_change = std::ranges::any_of(
        changeable, [&](const Changeable& one) { return (change.path + '.').starts_with(std::string(one.key) + '.'); });
    if (may_change) continue;
    refused.push_back(
        {Severity::error,
         {"--set " + change.path, 0, 0},
         fmt::format("this cannot change when a run is resumed; these can: {}; for anything else start a new run "
                     "with `pliant run`",
                     fmt::join(changeable | std::views::transform(&Changeable::key), ", "))});
  }
  if (!refused.empty()) throw InputError(std::move(refused));
}

/// The earlier configuration with the new values of the settings that may change.
Config changed(Config earlier, const Config& now) {
  for (const Changeable& one : changeable) one.take(earlier, now);
  return earlier;
}

void warn_of_stops(const Config& earlier, const Config& now, Console& console) {
  for (const JointConfig& joint : now.joints) {
    if (!joint.limits || joint.limit_stiffness || now.time.step == earlier.time.step) continue;
    console.warn(
        fmt::format("the stiffness of the stops of joint '{}' follows from 'time.step', and changes with it; "
                    "'limit_stiffness' fixes it",
                    joint.name));
  }
}

/// The first line in which the texts differ, for messages.
std::string first_difference(const std::string& then, const std::string& now) {
  const auto at = static_cast<std::size_t>(std::ranges::mismatch(then, now).in1 - then.begin());
  const auto before = at == 0 ? std::string::npos : then.rfind('\n', at - 1);
  const auto start = before == std::string::npos ? 0 : before + 1;
  const auto line = [&](const std::string& text) {
    return std::string(trimmed(text.substr(start, text.find('\n', at) - start)));
  };
  return fmt::format("'{}' then, '{}' now", line(then), line(now));
}

/// The checkpoint named, or those of the directory, with the ones to fall back on if it is damaged: newest first.
std::vector<fs::path> candidates(const fs::path& place) {
  std::error_code ignored;
  if (fs::is_directory(place, ignored)) {
    auto files = checkpoints_in(place);
    if (files.empty()) {
      throw FileError(fmt::format(
          "there is no checkpoint in '{}'; a run writes them where its input says so: 'checkpoint: {{every: 100}}'",
          place.string()));
    }
    return files;
  }
  refuse_input(place, "checkpoint");
  if (!fs::exists(place, ignored)) {
    throw FileError(fmt::format("there is no file '{}'{}", place.string(), similar_file(place)));
  }
  std::vector<fs::path> files{place};
  const auto all = checkpoints_in(place.has_parent_path() ? place.parent_path() : ".");
  const auto here = std::ranges::find(all, place.filename(), [](const fs::path& file) { return file.filename(); });
  if (here != all.end()) files.insert(files.end(), here + 1, all.end());
  return files;
}

/// The same on every rank. Collective.
std::vector<fs::path> shared_candidates(MPI_Comm comm, const fs::path& place) {
  std::string text;
  on_root(comm, [&] {
    for (const auto& file : candidates(place)) text += file.string() + '\0';
  });
  text = broadcast(comm, std::move(text));
  std::vector<fs::path> files;
  for (std::size_t at = 0; at < text.size(); at += files.back().string().size() + 1) files.emplace_back(&text[at]);
  return files;
}

ResumePoint newest_whole(MPI_Comm comm, const fs::path& place, Console& console) {
  const auto files = shared_candidates(comm, place);
  for (std::size_t i = 0;; ++i) {
    try {
      return {files[i], read_checkpoint_info(comm, files[i])};
    } catch (const FileError& error) {
      if (i + 1 == files.size()) throw;
      console.warn(fmt::format("{}; trying the one before, '{}'", error.what(), files[i + 1].string()));
    }
  }
}

void warn_of_other_options(const ResumePoint& from, Console& console) {
  if (from.info.petsc_options == petsc_options()) return;
  console.warn(
      fmt::format("the run had the PETSc options '{}', now they are '{}'", from.info.petsc_options, petsc_options()));
}

ExitCode go_on(MPI_Comm comm, const Config& config, Console& console, const ResumePoint& from) {
  warn_of_other_options(from, console);
  console.print(fmt::format("resuming from {} after step {}", from.file.string(), from.info.step));
  return resume_with_output(comm, config, console, from);
}

/// How the run in a directory has ended and how to continue it, in lines. Modes have no history and no end.
std::string state_of_run(const fs::path& directory) {
  std::error_code ignored;
  if (!fs::exists(directory / "history.csv", ignored)) return "";
  const nlohmann::ordered_json summary = summary_json(directory);
  const std::string outcome = summary.is_null() ? "" : summary.value("outcome", "");
  const auto files = checkpoints_in(directory);
  std::string text = "run: " + (outcome.empty() ? "not ended; it continues, or was killed" : outcome) + "\n";
  if (files.empty()) return text;
  text += fmt::format("newest checkpoint: {}", files.front().filename().string());
  if (outcome == "done") return text + "\n";
  return text + fmt::format("; to continue: pliant resume {}\n", directory.empty() ? "." : directory.string());
}

}  // namespace

ExitCode continue_command(MPI_Comm comm, const std::string& file, const std::vector<Override>& overrides,
                          Console& console) {
  const Config config = read_input_file(comm, file, overrides);
  const fs::path directory = config.output.directory, input = directory / "run.yaml";
  bool has_checkpoints = false, has_input = false, is_done = false;
  on_root(comm, [&] {
    std::error_code ignored;
    has_checkpoints = !checkpoints_in(directory).empty();
    has_input = fs::exists(input, ignored);
    is_done = summary_json(directory)["outcome"] == "done";
  });
  std::optional<ResumePoint> from;
  if (any_rank(comm, has_checkpoints)) from = newest_whole(comm, directory, console);
  if (!from && !any_rank(comm, has_input)) return run_with_output(comm, config, console);

  Config earlier =
      from ? read_input(from->info.input, from->file.string(), {}) : read_input_file(comm, input.string(), {});
  earlier.output.directory = config.output.directory;  // seen from here
  const std::string now = dump(config), then = dump(changed(earlier, config));
  if (then != now) {
    throw InputError({file, 0, 0},
                     fmt::format("'{0}' holds a run of another input: {1}. To continue that one: pliant resume {0}; "
                                 "to replace it leave --continue out; to keep both: --output DIR",
                                 directory.string(), first_difference(then, now)));
  }
  if (any_rank(comm, is_done) && dump(earlier) == now) {
    console.print(fmt::format("done already\nresults: {0}/result.xdmf, {0}/history.csv", directory.string()));
    return ExitCode::done;
  }
  if (!from) return run_with_output(comm, config, console);
  warn_of_stops(earlier, config, console);
  return go_on(comm, config, console, *from);
}

ExitCode resume_command(MPI_Comm comm, const std::string& place, const std::vector<Override>& overrides,
                        Console& console) {
  check_changes(overrides);
  const ResumePoint from = newest_whole(comm, place, console);
  // Where the results lie, wherever the run was started.
  const fs::path directory = from.file.has_parent_path() ? from.file.parent_path() : ".";
  std::vector<Override> changes{{"output.directory", directory.string()}};
  changes.insert(changes.end(), overrides.begin(), overrides.end());
  const Config config = read_input(from.info.input, from.file.string(), changes);
  const Config earlier = read_input(from.info.input, from.file.string(), {});
  changed(earlier, config);  // refuses what cannot change
  constexpr double rounding = 1e-9;
  if (analysis_of(config) != Analysis::static_equilibrium && config.time.end < from.info.time * (1.0 - rounding)) {
    throw InputError({"time.end", 0, 0}, fmt::format("the run is at t = {:.6g} s already: give a later end, or resume "
                                                     "one of its earlier checkpoints",
                                                     from.info.time));
  }
  warn_of_stops(earlier, config, console);
  return go_on(comm, config, console, from);
}

std::string info_text(MPI_Comm comm, const std::string& file) {
  bool is_one = false;
  on_root(comm, [&] {
    std::error_code ignored;
    if (fs::is_directory(file, ignored)) return;
    if (!fs::is_regular_file(file, ignored)) throw FileError(fmt::format("there is no file '{}'", file));
    is_one = is_checkpoint(file);
  });
  if (any_rank(comm, is_one)) {
    const CheckpointInfo info = read_checkpoint_info(comm, file);
    return fmt::format(
        "checkpoint{}, whole\nafter step {} at t = {:.6g}\nwritten on {} rank{} by\n{}PETSc options: {}\n"
        "continue with: pliant resume {}\n\nThe input:\n{}",
        info.title.empty() ? "" : fmt::format(" of '{}'", info.title), info.step, info.time, info.ranks,
        info.ranks == 1 ? "" : "s", info.program, info.petsc_options.empty() ? "none" : info.petsc_options, file,
        info.input);
  }
  std::string text;
  on_root(comm, [&] {
    const fs::path result = result_file(file);
    naming(result, [&] { text = describe_result(result) + state_of_run(result.parent_path()); });
  });
  return broadcast(comm, std::move(text));
}

}  // namespace pliant
