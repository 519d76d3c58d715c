/// summary.json: how a run ended, what it took, what its solver did; for reports and scripts.
#pragma once

#include "run/energy_watch.hpp"
#include "run/simulation.hpp"

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace pliant {

/// Wall-clock seconds of rank 0.
struct RunSeconds {
  double total = 0.0, set_up = 0.0, mesh = 0.0, assembly = 0.0, factorization = 0.0, solve = 0.0, output = 0.0;

  double rest() const;  ///< what none of the others counts; the mesh is a part of the set-up
};

/// The step that needed most; of none the iterations are -1.
struct WorstStep {
  std::int64_t step = 0;
  double time = 0.0;
  int newton_iterations = -1;
};

struct Summary {
  std::string outcome;  ///< "done", "interrupted" or "failed"
  std::string message;  ///< why, if not done
  int ranks = 1;
  RunSeconds seconds;
  StepStatistics steps;
  SolverStatistics solver;
  WorstStep worst;
  std::optional<EnergyWatch::Growth> energy_growth;
};

/// Replaces summary.json. Of a resumed run it tells of the part since then. Not collective.
void write_summary(const std::filesystem::path& directory, const Summary& summary);

/// The summary that lies there; null where there is none, as while the run goes on. Not collective.
nlohmann::ordered_json summary_json(const std::filesystem::path& directory);

/// Not collective.
void remove_summary(const std::filesystem::path& directory);

}  // namespace pliant
