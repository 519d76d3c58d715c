/// summary.json: how a run ended, its costs, and what its solver did; for reports and scripts.
#pragma once

#include "run/discretization_error.hpp"
#include "run/energy_watch.hpp"
#include "run/simulation.hpp"

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace pliant {

/// Wall-clock seconds of rank 0.
struct RunSeconds {
  double total = 0.0, set_up = 0.0, mesh = 0.0, assembly = 0.0, factorization = 0.0, solve = 0.0, output = 0.0;

  double rest() const;  ///< time that none of the others counts; the mesh is a part of the set-up
};

/// The step with the most Newton iterations; -1 iterations if there is none.
struct WorstStep {
  std::int64_t step = 0;
  double time = 0.0;
  int newton_iterations = -1;
};

/// A critical point of a path, and the step that has passed it.
struct PassedPoint {
  std::int64_t step = 0;
  CriticalPoint point;
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
  std::optional<MeshErrorWatch> mesh_error;  ///< if the input asks for it
  std::vector<PassedPoint> critical_points;  ///< along a path
  std::vector<std::string> warnings;         ///< as the terminal showed them
  std::vector<std::string> notes;            ///< as the terminal showed them, or would have without --quiet
};

/// Replaces summary.json. For a resumed run it covers the part since resuming. Not collective.
void write_summary(const std::filesystem::path& directory, const Summary& summary);

/// Reads the summary; null if there is none, for instance while the run continues. Not collective.
nlohmann::ordered_json summary_json(const std::filesystem::path& directory);

/// Removes summary.json. Not collective.
void remove_summary(const std::filesystem::path& directory);

}  // namespace pliant
