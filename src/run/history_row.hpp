/// The numbers that a run reports for each step: the columns of history.csv (docs/output.md).
#pragma once

#include "model/rigid_states.hpp"
#include "run/field_columns.hpp"
#include "run/ledger.hpp"
#include "run/simulation.hpp"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

class HistoryRow {
 public:
  /// The columns depend on what the model has, and on the ledger's mechanisms. `model` outlives the object. Throws
  /// InputError if a column of the input has the name of another. Collective.
  HistoryRow(const Config& config, Model& model, const Ledger& ledger);

  const std::vector<std::string>& columns() const { return columns_; }
  /// One number for each column, the same on every rank; SI units. Collective.
  std::vector<double> values(const StepRecord& record, const Ledger& ledger);
  /// The fields of the state of the last row.
  ResultFields& fields() { return fields_; }

 private:
  std::vector<std::string> names_of_columns(const Config& config, const Ledger& ledger) const;
  /// Positions and velocities of the probes, and then their displacements.
  std::array<std::vector<double>, 2> probe_states(const StepRecord& record);
  /// Gauge pressure [Pa] and volume [m^3] of each cavity.
  std::vector<double> cavity_states(const StepRecord& record);
  std::vector<double> tendon_states(const StepRecord& record);
  /// Length [m] and force [N] of each spring.
  std::vector<double> spring_states(const StepRecord& record);
  std::vector<double> lengths_of_rods(const StepRecord& record);
  double contact_energy(const StepRecord& record);

  Model& model_;
  ResultFields fields_;
  FieldColumns field_columns_;
  RigidStates rigid_states_;
  std::optional<double> static_time_;  // at which formulas are evaluated while the load factor grows [s]
  bool follows_path_;
  bool counts_unstable_modes_;  // of a path; the pivots of an unsymmetric matrix have no meaning
  std::vector<std::string> columns_;
};

}  // namespace pliant
