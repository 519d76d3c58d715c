#include "study/sweep.hpp"

#include "base/file.hpp"
#include "base/text.hpp"
#include "input/input.hpp"
#include "io/history_reader.hpp"
#include "io/history_writer.hpp"
#include "run/summary.hpp"
#include "study/earlier_runs.hpp"
#include "study/history_plots.hpp"
#include "study/result_columns.hpp"
#include "study/sweep_plots.hpp"
#include "study/swept_keys.hpp"
#include "study/varied_input.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace pliant {
namespace {

namespace fs = std::filesystem;

/// For people and names of files.
std::string plain_text(const InputNode& value) {
  return value.kind == InputNode::Kind::scalar ? value.text : flow_text(value);
}

struct Case {
  std::vector<Override> changes;  ///< all of them
  fs::path directory;
};

std::string in_words(const Ended& how) {
  if (how.code == 0) return "done";
  if (how.code == static_cast<int>(ExitCode::interrupted) || how.code > 128) return "interrupted";
  return fmt::format("exit code {}", how.code);
}

std::string in_words(std::size_t warnings) {
  if (warnings == 0) return "";
  return warnings == 1 ? ", 1 warning" : fmt::format(", {} warnings", warnings);
}

class Sweep {
 public:
  Sweep(std::string file, const std::vector<Override>& changes, const SweepOptions& options, Console& console)
      : file_(std::move(file)), options_(options), console_(console) {
    std::ifstream stream(file_, std::ios::binary);
    if (!stream || fs::is_directory(file_)) {
      throw InputError({file_, 0, 0}, "cannot read it: give the path of an input file (YAML)");
    }
    text_.assign(std::istreambuf_iterator<char>(stream), {});
    swept_ = SweptKeys(text_, file_, changes, options_);
    refuse_taken_names();
    make_cases();
  }

  ExitCode run() {
    const int ranks = options_.ranks;
    const int at_once = options_.at_once > 0 ? options_.at_once : std::max(1, usable_processors() / ranks);
    console_.print(fmt::format("{} runs of {}, {} at a time, on {} rank{} each", cases_.size(), file_,
                               std::min<std::size_t>(static_cast<std::size_t>(at_once), cases_.size()), ranks,
                               ranks == 1 ? "" : "s"));
    std::vector<Program> programs;
    for (const Case& one : cases_) programs.push_back(program(one));
    std::size_t done = 0, num_with_warnings = 0;
    ended_ = run_all(programs, options_.environment, at_once, [&](std::size_t index, const Ended& how) {
      const std::size_t warnings = how.code == static_cast<int>(ExitCode::input) ? 0 : num_warnings(cases_[index]);
      num_with_warnings += warnings > 0 ? 1 : 0;
      console_.print(fmt::format("[{}/{}] {}: {} after {:.3g} s{}", ++done, cases_.size(),
                                 cases_[index].directory.filename().string(), in_words(how), how.seconds,
                                 in_words(warnings)));
    });
    for (std::size_t i = 0; i < cases_.size(); ++i) {
      histories_.push_back(read_labelled_history(label_of(keys_, i), cases_[i].directory / "history.csv"));
    }
    print_table();
    write_text_atomically(directory_ / "sweep.csv", csv());
    const std::size_t plots = draw();
    console_.print(fmt::format("results: {0}/sweep.csv, {1} plots {0}/*.svg; of each run: {0}/NN_.../",
                               directory_.string(), plots));
    if (num_with_warnings > 0) {
      console_.warn(fmt::format("{} of {} runs {} warnings: they are in {}/*/log.txt, and in summary.json of each run",
                                num_with_warnings, cases_.size(), num_with_warnings == 1 ? "has" : "have",
                                directory_.string()));
    }
    return outcome();
  }

 private:
  void make_cases() {
    const auto values = swept_.cases();
    const std::size_t count = values.size();
    const auto& swept = swept_.keys();
    for (std::size_t k = 0; k < swept.size(); ++k) {
      const auto& range = swept[k].range;
      const std::string unit = unit_of_key(swept[k].path);
      keys_.push_back({swept_.short_name(k), {}, unit == "1" ? "" : unit, range.has_value()});
      if (range && range->is_logarithmic) keys_[k].scale = Scale::logarithmic;
      for (const auto& of_case : values) keys_[k].texts.push_back(plain_text(of_case[k]));
    }
    const std::size_t width = std::to_string(count).size();
    for (std::size_t number = 0; number < count; ++number) {
      Case one{swept_.fixed(), {}};
      for (std::size_t k = 0; k < swept.size(); ++k) {
        one.changes.push_back({swept[k].path, flow_text(values[number][k])});
      }
      const std::string name =
          file_name_of(fmt::format("{:0{}}_{}", number + 1, std::max<std::size_t>(width, 2), label_of(keys_, number)));
      const fs::path directory = read_input(text_, file_, one.changes).output.directory;
      if (number == 0) directory_ = directory;
      one.directory = directory_ / name;
      cases_.push_back(std::move(one));
    }
    std::vector<fs::path> runs;
    for (const Case& one : cases_) runs.push_back(one.directory);
    refuse_other_runs(directory_, runs);
    refuse_missing_columns();
    make_directory(directory_);
  }

  /// Looks into one of the cases that differ by numbers alone, which have the same columns.
  void refuse_missing_columns() const {
    if (options_.results.empty()) return;
    std::set<std::vector<std::string>> seen;
    std::vector<Config> inputs;
    for (std::size_t i = 0; i < cases_.size(); ++i) {
      std::vector<std::string> words = values_of(i);
      std::erase_if(words, [](const std::string& text) {
        return parse_number(std::string_view(text).substr(0, text.find(' '))).has_value();
      });
      if (seen.insert(words).second) inputs.push_back(read_input(text_, file_, cases_[i].changes));
    }
    require_columns(PETSC_COMM_WORLD, options_.results, inputs);
  }

  Program program(const Case& one) const {
    Program program;
    if (options_.ranks > 1) {
      program.arguments = {
          "mpirun", "--quiet", "--bind-to", "none", "--oversubscribe", "-n", std::to_string(options_.ranks)};
    }
    for (const std::string& argument : {fs::read_symlink("/proc/self/exe").string(), std::string("run"), file_,
                                        std::string("--output"), one.directory.string()}) {
      program.arguments.push_back(argument);
    }
    if (options_.continues) program.arguments.emplace_back("--continue");
    for (const Override& change : one.changes) {
      program.arguments.insert(program.arguments.end(), {"--set", change.path + "=" + change.value});
    }
    if (!options_.petsc_options.empty()) {
      program.arguments.push_back("--");
      for (const std::string& option : options_.petsc_options) program.arguments.push_back(option);
    }
    make_directory(one.directory);
    program.log = log_of(one);
    std::error_code ignored;
    if (!options_.continues) fs::remove(program.log, ignored);
    return program;
  }

  /// What the run prints.
  static std::string log_of(const Case& one) { return (one.directory / "log.txt").string(); }
  /// Those in the summary of a run that has ended.
  static std::size_t num_warnings(const Case& one) {
    const nlohmann::ordered_json summary = summary_json(one.directory);
    return summary.contains("warnings") ? summary["warnings"].size() : 0;
  }

  /// Results are columns of sweep.csv, next to others.
  void refuse_taken_names() const {
    std::vector<std::string> taken{"directory", "exit_code", "seconds"};
    for (const auto& key : swept_.keys()) taken.push_back(key.path);
    for (const RunNumber& result : options_.results) {
      if (std::ranges::find(taken, result.name) != taken.end()) {
        throw InputError({"--result " + result.name, 0, 0},
                         "sweep.csv has a column of this name already; name the result differently, as in "
                         "--result 'highest=max(tip_z)'");
      }
      taken.push_back(result.name);
    }
  }

  /// Those of the histories without those of the results' names.
  std::vector<std::string> history_columns() const {
    std::vector<std::string> names = columns_of(histories_);
    std::erase_if(names, [&](const std::string& name) {
      return std::ranges::find(options_.results, name, &RunNumber::name) != options_.results.end();
    });
    return names;
  }

  /// The last value of a column, NaN if there is none.
  double last(std::size_t run, std::string_view column) const {
    const auto* values = histories_[run].table.find(column);
    return values == nullptr || values->empty() ? std::numeric_limits<double>::quiet_NaN() : values->back();
  }

  std::vector<std::string> values_of(std::size_t run) const {
    std::vector<std::string> texts;
    for (const SweptValues& key : keys_) texts.push_back(key.texts[run]);
    return texts;
  }

  void print_table() const {
    std::vector<std::vector<std::string>> rows(1);
    for (const SweptValues& key : keys_) rows[0].push_back(key.name);
    for (const std::string& name : {std::string("end"), std::string("steps"), axis_label(histories_),
                                    std::string("newton"), std::string("seconds")}) {
      rows[0].push_back(name);
    }
    for (const RunNumber& result : options_.results) {
      const std::string unit = result.unit(histories_);
      rows[0].push_back(unit.empty() ? result.name : fmt::format("{} [{}]", result.name, unit));
    }
    for (std::size_t i = 0; i < cases_.size(); ++i) {
      auto row = values_of(i);
      row.push_back(in_words(ended_[i]));
      double iterations = 0.0;
      if (const auto* newton = histories_[i].table.find("newton_iterations")) {
        for (const double n : *newton) iterations += n;
      }
      for (const double number : {last(i, "step"), last(i, "time"), iterations, ended_[i].seconds}) {
        row.push_back(fmt::format("{:.4g}", number));
      }
      for (const RunNumber& result : options_.results) {
        row.push_back(fmt::format("{:.6g}", result.of(histories_[i].table)));
      }
      rows.push_back(std::move(row));
    }
    std::vector<std::size_t> widths(rows[0].size(), 0);
    for (const auto& row : rows) {
      for (std::size_t k = 0; k < row.size(); ++k) widths[k] = std::max(widths[k], row[k].size());
    }
    for (const auto& row : rows) {
      std::string line;
      for (std::size_t k = 0; k < row.size(); ++k) line += fmt::format("{:<{}}  ", row[k], widths[k]);
      console_.print(std::string(line, 0, line.find_last_not_of(' ') + 1));
    }
  }

  std::string csv() const {
    std::vector<std::string> header;
    for (const auto& key : swept_.keys()) header.push_back(key.path);
    header.emplace_back("directory");
    std::vector<std::vector<double>> in_si;  // of the keys whose values have a unit
    for (std::size_t k = 0; k < keys_.size(); ++k) {
      auto numbers = keys_[k].unit.empty() ? std::nullopt : si_values(keys_[k]);
      if (!numbers) continue;
      header.push_back(fmt::format("{} [{}]", swept_.keys()[k].path, keys_[k].unit));
      in_si.push_back(std::move(*numbers));
    }
    for (const char* name : {"exit_code", "seconds"}) header.emplace_back(name);
    const std::vector<std::string> names = history_columns();
    for (const RunNumber& result : options_.results) header.push_back(result.name);
    header.insert(header.end(), names.begin(), names.end());
    std::string text = csv_header(header) + "\n";
    for (std::size_t i = 0; i < cases_.size(); ++i) {
      auto row = values_of(i);
      row.push_back(cases_[i].directory.filename().string());
      std::vector<double> numbers;
      for (const auto& of_key : in_si) numbers.push_back(of_key[i]);
      numbers.insert(numbers.end(), {static_cast<double>(ended_[i].code), ended_[i].seconds});
      for (const RunNumber& result : options_.results) numbers.push_back(result.of(histories_[i].table));
      for (const std::string& name : names) numbers.push_back(last(i, name));
      text += csv_header(row) + "," + csv_row(numbers) + "\n";
    }
    return text;
  }

  /// One plot for each column that varies in some run, and those of each result. Returns how many.
  std::size_t draw() const {
    const ColumnPlots drawn(histories_, directory_);
    // A key that goes along with another one adds nothing to the labels.
    std::vector<SweptValues> of_their_own;
    for (std::size_t k = 0; k < keys_.size(); ++k) {
      if (!swept_.keys()[k].goes_with) of_their_own.push_back(keys_[k]);
    }
    std::size_t count = 0;
    for (const std::string& name : history_columns()) {
      if (!is_bookkeeping(name) && drawn.draw(name)) ++count;
    }
    for (const RunNumber& result : options_.results) {
      SweptResult found{result.name, result.unit(histories_), {}};
      for (const LabelledHistory& history : histories_) found.values.push_back(result.of(history.table));
      count += draw_result(of_their_own, found, directory_);
    }
    return count;
  }

  ExitCode outcome() const {
    ExitCode code = ExitCode::done;
    for (std::size_t i = 0; i < ended_.size(); ++i) {
      if (ended_[i].code == 0) continue;
      if (in_words(ended_[i]) == "interrupted") return ExitCode::interrupted;
      if (code != ExitCode::done) continue;
      const std::array known{ExitCode::input, ExitCode::solve, ExitCode::file, ExitCode::unexpected};
      const auto same = std::ranges::find(known, static_cast<ExitCode>(ended_[i].code));
      code = same == known.end() ? ExitCode::solve : *same;
      console_.warn(fmt::format("run {} failed; its output is in {}", i + 1, log_of(cases_[i])));
    }
    return code;
  }

  std::string file_, text_;
  const SweepOptions& options_;
  Console& console_;
  SweptKeys swept_;
  std::vector<SweptValues> keys_;  // in the order of swept_
  fs::path directory_;
  std::vector<Case> cases_;
  std::vector<Ended> ended_;
  std::vector<LabelledHistory> histories_;
};

}  // namespace

ExitCode sweep_command(const std::string& file, const std::vector<Override>& changes, const SweepOptions& options,
                       Console& console) {
  return Sweep(file, changes, options, console).run();
}

}  // namespace pliant
