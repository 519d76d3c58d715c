/// The report on why a run could not continue, as numbers and as text.
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
  std::optional<FailedStage> stage;  ///< nullopt if the solver does not report it
  bool is_input_error = false;       ///< a formula of the input is not a finite number there
};

/// A cell. Trivially copyable, as ReportedNode is, so that ranks can exchange them.
struct ReportedCell {
  double volume_ratio = 1.0;  ///< the least J in it; NaN counts as the worst
  double quality = 1.0;
  double reference_quality = 1.0;
  std::size_t body = 0;                    ///< in FailureReport::bodies
  std::array<double, 3> X{};               ///< its middle in the reference configuration [m]
  std::int64_t row = 0;                    ///< of state.h5
  std::array<std::int64_t, 4> vertices{};  ///< numbers in the mesh, from 0
};

struct ReportedNode {
  double residual = 0.0;      ///< [N]; NaN counts as the worst
  std::size_t body = 0;       ///< in FailureReport::bodies
  std::array<double, 3> X{};  ///< [m]
  std::int64_t row = 0;       ///< of state.h5
  std::int64_t number = 0;    ///< of the vertex in the mesh, from 0; -1 for a node in the middle of an edge
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
  double last_time = 0.0;      ///< its end [s]; in a static problem, the load factor
  int max_iterations = 0;
  std::string shorter_steps;    ///< how to ask for shorter steps in the input
  bool has_load_steps = false;  ///< of a static problem, not along a path
  bool is_quasistatic = false;
  bool has_contact = false;  ///< no path can be followed then
  bool has_barriers = false;
  std::string doubt_about_units;  ///< the warning about a body's constants; empty: none
  std::string load_at_once;  ///< where the input has a load that is not zero at the start, if that may be the cause
  std::string grown_load;    ///< a formula by which it would grow
  std::vector<ReportedBody> bodies;
  std::vector<ReportedCell> worst_cells;  ///< the worst first, judged at the last iterate
  std::vector<ReportedNode> worst_nodes;  ///< likewise; empty if the stage is not known
};

/// Remedies to try, the most promising first; never empty.
std::vector<std::string> advice(const FailureReport& report, const Failure& failure);

/// The report as YAML with comments, for people and for programs.
std::string to_yaml(const FailureReport& report, const Failure& failure);

}  // namespace pliant
