/// Why a run could not go on, as numbers and as text.
#pragma once

#include "solver/failed_stage.hpp"
#include "time/step.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// A step that failed after every retry.
struct Failure {
  std::string reason;
  Step tried;
  std::optional<FailedStage> stage;  ///< nothing if the solver does not tell
  bool is_mistake = false;           ///< a formula of the input is no number there
};

/// Trivially copyable, as ReportedNode is, so that ranks can exchange them.
struct ReportedCell {
  double volume_ratio = 1.0;  ///< the least J in it; NaN counts as the worst
  double quality = 1.0;
  double reference_quality = 1.0;
  std::size_t body = 0;                    ///< in FailureReport::bodies
  std::array<double, 3> X{};               ///< its middle in the reference configuration [m]
  std::int64_t row = 0;                    ///< of state.h5
  std::array<std::int64_t, 4> vertices{};  ///< their numbers in the mesh, from 0
};

struct ReportedNode {
  double residual = 0.0;      ///< [N]; NaN counts as the worst
  std::size_t body = 0;       ///< in FailureReport::bodies
  std::array<double, 3> X{};  ///< [m]
  std::int64_t row = 0;       ///< of state.h5
  std::int64_t number = 0;    ///< of the vertex in the mesh, from 0; -1 in the middle of an edge
};

struct ReportedBody {
  std::string name;
  double residual = 0.0;  ///< norm over its nodes [N]
  double volume_ratio = 1.0;
};

struct FailureReport {
  std::string title;
  std::string file;            ///< the input
  std::int64_t last_step = 0;  ///< completed
  double last_time = 0.0;      ///< its end [s]; of a static problem the load factor
  int max_iterations = 0;
  std::string shorter_steps;  ///< how the input asks for them
  std::vector<ReportedBody> bodies;
  std::vector<ReportedCell> worst_cells;  ///< the worst first; by their state where the iteration ended
  std::vector<ReportedNode> worst_nodes;  ///< likewise; none if the stage is not known
};

/// What to try, the most promising first; never empty.
std::vector<std::string> advice(const FailureReport& report, const Failure& failure);

/// For people and for programs: YAML with comments.
std::string to_yaml(const FailureReport& report, const Failure& failure);

}  // namespace pliant
