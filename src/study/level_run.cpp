#include "study/level_run.hpp"

#include "base/error.hpp"
#include "base/text.hpp"
#include "petsc/copy_of.hpp"
#include "run/history_row.hpp"
#include "run/simulation.hpp"
#include "study/sample.hpp"

#include <algorithm>
#include <chrono>
#include <limits>
#include <optional>

#include <fmt/format.h>

namespace pliant {
namespace {

/// The history of a simulation in memory.
class KeptHistory {
 public:
  KeptHistory(const Config& config, Model& model, const Simulation& simulation, std::span<const RunNumber> numbers)
      : simulation_(simulation), row_(config, model, simulation.ledger()) {
    table_.names = row_.columns();
    table_.columns.resize(table_.names.size());
    for (const RunNumber& number : numbers) {
      if (table_.find(number.column) != nullptr) continue;
      throw InputError({"--result " + number.name, 0, 0}, fmt::format("the history has no column '{}'{}", number.column,
                                                                      did_you_mean(number.column, table_.names)));
    }
    add();
  }

  void add() {
    const std::vector<double> values = row_.values(simulation_.record(), simulation_.ledger());
    for (std::size_t i = 0; i < values.size(); ++i) table_.columns[i].push_back(values[i]);
  }
  const HistoryTable& table() const { return table_; }

 private:
  const Simulation& simulation_;
  HistoryRow row_;
  HistoryTable table_;
};

}  // namespace

void report_new_warnings(const Model& model, Console& console) {
  for (const Diagnostic& diagnostic : model.diagnostics()) {
    if (diagnostic.severity != Severity::warning) continue;
    if (std::ranges::find(console.warnings(), to_string(diagnostic)) == console.warnings().end()) {
      console.report(diagnostic);
    }
  }
}

LevelRun run_level(const Config& config, Model& model, std::span<const RunNumber> numbers, const std::string& name,
                   Console& console) {
  const auto start = std::chrono::steady_clock::now();
  Simulation simulation(config, model);
  std::optional<KeptHistory> history;
  if (!numbers.empty()) history.emplace(config, model, simulation, numbers);
  const Abscissa abscissa =
      analysis_of(config) == Analysis::static_equilibrium ? Abscissa::load_factor : Abscissa::time;
  LevelRun run;
  while (run.failure.empty() && !simulation.finished()) {
    const StepOutcome outcome = simulation.advance();
    if (outcome.kind == StepOutcome::Kind::failed) run.failure = outcome.reason;
    if (outcome.kind != StepOutcome::Kind::accepted) continue;
    if (history) history->add();
    run.largest_q = std::max(run.largest_q, nodal_mean_square(simulation.record().q));
    run.largest_v = std::max(run.largest_v, nodal_mean_square(simulation.record().v));
    console.progress(fmt::format("{}: {}", name, instant_text(abscissa, simulation.record().time)));
  }
  run.q = copy_of(simulation.record().q);
  run.v = copy_of(simulation.record().v);
  run.steps = simulation.record().step;
  run.newton_iterations = simulation.solver_statistics().newton_iterations;
  for (const RunNumber& number : numbers) {
    run.results.push_back(run.failure.empty() ? number.of(history->table()) : std::numeric_limits<double>::quiet_NaN());
  }
  run.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return run;
}

}  // namespace pliant
