#include "command/report.hpp"

#include "base/error.hpp"
#include "base/file.hpp"
#include "command/page_data.hpp"
#include "io/history_reader.hpp"
#include "io/packed_result.hpp"
#include "petsc/collective.hpp"
#include "run/summary.hpp"
#include "study/labelled_history.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <filesystem>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>
#include <thread>
#include <vector>

#include <fmt/format.h>

namespace pliant {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t most_rows = 4000;  // rows of the history; a plot has fewer columns of pixels

/// The text of a file; empty if there is none.
std::string text_of(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

/// Every n-th row, and the last one; for iterations the largest of the rows that each stands for.
Json json_of(const HistoryTable& history, Page& page) {
  const std::size_t rows = history.num_rows(), every = std::max<std::size_t>(1, (rows + most_rows - 1) / most_rows);
  Json json{{"columns", history.names}, {"every", every}, {"steps", rows == 0 ? 0 : rows - 1}};
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i + 1 < rows; i += every) kept.push_back(i);
  if (rows > 0) kept.push_back(rows - 1);
  std::vector<double> values;
  for (std::size_t c = 0; c < history.names.size(); ++c) {
    const bool counts = history.names[c].ends_with("_iterations");
    for (std::size_t k = 0; k < kept.size(); ++k) {
      const auto last = history.columns[c].begin() + static_cast<std::ptrdiff_t>(kept[k]);
      const auto first = k > 0 ? history.columns[c].begin() + static_cast<std::ptrdiff_t>(kept[k - 1]) + 1 : last;
      values.push_back(counts ? *std::max_element(first, last + 1) : *last);
    }
  }
  json["rows"] = kept.size();
  json["values"] = page.block(values);
  return json;
}

/// The columns of the history that are taken from fields, with their titles and units.
Json json_of_columns(const std::string& input) {
  Json columns = Json::array();
  for (const FieldColumn& column : columns_from_fields(input)) {
    columns.push_back({{"column", column.name}, {"title", column.title}, {"unit", column.unit}});
  }
  return columns;
}

/// Whether the run in a directory has ended: its summary is written after the last row. A run that was resumed leaves
/// that of the earlier one until it ends. Modes have neither.
bool has_ended(const fs::path& directory) {
  std::error_code no_summary, no_history;
  const auto summary = fs::last_write_time(directory / "summary.json", no_summary);
  const auto history = fs::last_write_time(directory / "history.csv", no_history);
  return no_history || (!no_summary && summary >= history);
}

/// What the page says of a run besides its frames.
Json json_of_run(const fs::path& file, const ResultReader& result, Page& page) {
  const fs::path directory = file.parent_path();
  Json json{{"title", result.title()}, {"directory", fs::absolute(file).parent_path().string()}};
  json["history"] = json_of(read_history(directory / "history.csv"), page);
  json["input"] = text_of(directory / "run.yaml");
  json["taken"] = json_of_columns(text_of(directory / "run.yaml"));
  json["summary"] = summary_json(directory);
  return json;
}

/// The page of one result or of two; returns the line for the terminal. `is_last`: the page is not renewed.
std::string write_page(const std::vector<fs::path>& files, const ReportOptions& options, bool is_last) {
  require_viewer();
  const fs::path by_default = files.front().parent_path() / (files.size() == 1 ? "report.html" : "comparison.html");
  const fs::path output = options.output.empty() ? by_default : fs::path(options.output);
  std::deque<ResultReader> results;  // which are not moved
  Page page;
  Json report{{"format", 1}};
  add_origin(report);
  if (!is_last) report["watch"] = *options.watch;
  for (const fs::path& file : files) {
    naming(file, [&] { results.emplace_back(file); });
    const Json of_run = json_of_run(file, results.back(), page);
    if (results.size() == 1) {
      report.update(of_run);
    } else {
      report["other"] = of_run;
    }
  }
  const double left = options.megabytes * 1e6 - static_cast<double>(page.filled(report).size());
  const auto share = static_cast<std::size_t>(std::max(left, 0.0)) / files.size();
  std::string frames;
  for (std::size_t i = 0; i < files.size(); ++i) {
    PackedResult packed;
    naming(files[i], [&] { packed = pack_result(results[i], share); });
    (i == 0 ? report : report["other"])["result"] = json_of(packed, page);
    frames += fmt::format("{}{} of {}", i == 0 ? "" : " and ", packed.frames.size(), packed.num_frames);
  }
  std::string text = page.filled(report);
  write_text_atomically(output, text);
  const double size = static_cast<double>(text.size()) * 1e-6;
  return fmt::format("{}: {:.1f} MB, {} frames{}; open it in a browser", output.string(), size, frames,
                     size > options.megabytes ? " (the data besides the frames need this much)" : "");
}

}  // namespace

void report_command(MPI_Comm comm, const ReportOptions& options, Console& console) {
  on_root(comm, [&] {
    std::vector<fs::path> files{result_file(options.place)};
    if (!options.other.empty()) files.push_back(result_file(options.other));
    const auto have_ended = [&] {
      return std::ranges::all_of(files, [](const fs::path& file) { return has_ended(file.parent_path()); });
    };
    // Asked before the page is written: else a run that ends meanwhile would leave a page without its end.
    bool is_last = !options.watch || have_ended();
    // A running simulation may be writing the result: reading it is tried again.
    const auto write = [&] {
      constexpr int most_tries = 50;
      constexpr std::chrono::milliseconds pause(100);
      for (int n = 1;; ++n) {
        try {
          return hdf5_in_child(files.front(), [&] { return write_page(files, options, is_last); });
        } catch (const FileError&) {
          if (is_last || n == most_tries) throw;
        }
        std::this_thread::sleep_for(pause);
      }
    };
    console.print(write());
    if (is_last) return;
    console.print(fmt::format("renewed every {:g} s until the run ends; Ctrl-C ends it earlier", *options.watch));
    while (!is_last) {
      std::this_thread::sleep_for(std::chrono::duration<double>(*options.watch));
      is_last = have_ended();
      const std::string line = write();
      if (is_last) console.print("the run has ended; " + line);
    }
  });
}

}  // namespace pliant
