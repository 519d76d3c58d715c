#include "study/result_columns.hpp"

#include "base/text.hpp"
#include "input/output_fields.hpp"
#include "model/model.hpp"
#include "run/history_row.hpp"
#include "run/simulation.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace pliant {
namespace {

/// Columns that the run of an input has whatever its mesh is.
std::vector<std::string> certain_columns(const Config& config) {
  std::vector<std::string> names(first_columns.begin(), first_columns.end());
  for (const ProbeConfig& probe : config.probes) {
    for (const char* suffix : {"_x", "_y", "_z", "_vx", "_vy", "_vz", "_ux", "_uy", "_uz"}) {
      names.push_back(probe.name + suffix);
    }
  }
  for (const FieldColumnConfig& column : config.output.history) names.push_back(column.name);
  return names;
}

/// All columns; none if the input has no model, which is for its run to say.
std::vector<std::string> history_columns(MPI_Comm comm, const Config& config) {
  try {
    Model model(comm, config);
    const Simulation simulation(config, model);
    return HistoryRow(config, model, simulation.ledger()).columns();
  } catch (const InputError&) {
    return {};
  } catch (const FileError&) {
    return {};
  } catch (const SolveError&) {
    return {};
  }
}

/// " (did you mean ...?)" by the name, or by what it begins with; else all that there are.
std::string similar_columns(std::string name, const std::vector<std::string>& known) {
  while (true) {
    if (std::string found = did_you_mean(name, known); !found.empty()) return found;
    const std::size_t last = name.rfind('_');
    if (last == std::string::npos) return "; it has " + joined(known);
    name.resize(last);
  }
}

}  // namespace

void require_columns(MPI_Comm comm, std::span<const RunNumber> numbers, std::span<const Config> inputs) {
  std::vector<RunNumber> missing(numbers.begin(), numbers.end());
  std::vector<std::string> known;
  const auto look_in = [&](const std::vector<std::string>& names) {
    std::erase_if(missing, [&](const RunNumber& n) { return std::ranges::find(names, n.column) != names.end(); });
    for (const std::string& name : names) {
      if (std::ranges::find(known, name) == known.end()) known.push_back(name);
    }
  };
  for (const Config& input : inputs) look_in(certain_columns(input));
  bool has_model = false;
  for (const Config& input : inputs) {
    if (missing.empty()) return;
    const std::vector<std::string> names = history_columns(comm, input);
    has_model = has_model || !names.empty();
    look_in(names);
  }
  if (missing.empty() || !has_model) return;
  const RunNumber& number = missing.front();
  throw InputError({"--result " + number.name, 0, 0}, fmt::format("history.csv has no column '{}'{}", number.column,
                                                                  similar_columns(number.column, known)));
}

}  // namespace pliant
