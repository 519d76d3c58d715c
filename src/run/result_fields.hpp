/// The fields of a result (input/output_fields.hpp) at the end of a step.
#pragma once

#include "energy/stress.hpp"
#include "fem/patch_recovery.hpp"
#include "input/output_fields.hpp"
#include "io/result_writer.hpp"
#include "model/model.hpp"
#include "run/discretization_error.hpp"
#include "run/rod_fields.hpp"
#include "run/shell_drawing.hpp"
#include "run/shell_fields.hpp"
#include "run/simulation.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace pliant {

/// The parts of a cell's stress, and the quantities that go with them. At nodes: what is recovered from the cells.
struct CellState {
  std::array<std::array<double, 6>, num_stress_parts> cauchy{};
  std::array<double, num_stress_parts> energy_density{};
  double volume_ratio = 1.0;
  double softening = 0.0;
  Tensor3<double> H{};  ///< grad u

  std::array<double, 6> total_cauchy() const;
};

/// A field's values on this rank, those of ghosts included: `components` by local node or cell.
struct FieldValues {
  OutputFieldInfo info;
  const char* unit = "";
  FieldLocation location = FieldLocation::node;
  std::vector<double> values;

  std::size_t width() const { return static_cast<std::size_t>(num_components(info.shape)); }
};

/// The components of a field of shells or of rods, in the state of a facet or a section.
void put_shell_field(std::string_view name, const LayerState& state, double* out);
double rod_field(std::string_view name, const RodResultants& of);

/// The unit of a field; empty: none.
const char* unit_of_field(std::string_view name);

class ResultFields {
 public:
  /// `model` outlives the object. Collective.
  ResultFields(const Config& config, Model& model);

  /// Fields of the input, in its order or another; those that the model does not have are left out. What was computed
  /// for a step is kept until `forget`. Collective.
  std::vector<FieldValues> at(const StepRecord& record, std::span<const std::string> names);
  /// Collective; only if the input asks for the error.
  const MeshError& mesh_error(const StepRecord& record) { return mesh_error_->at(record); }
  /// The triangles of a shell, and the segments of all rods, for columns that are taken from them. Collective.
  const std::vector<LayerTriangle>& triangles_of_shell(std::size_t shell, const StepRecord& record);
  const RodState& rods(const StepRecord& record);
  void forget();
  bool has_mesh_error() const { return mesh_error_.has_value(); }

 private:
  const std::vector<CellState>& cells(const StepRecord& record);
  const std::vector<CellState>& nodes(const StepRecord& record);
  std::vector<double> of_nodes(Vec values);
  void add_contact_fields(const StepRecord& record, std::span<const std::string> names,
                          std::vector<FieldValues>& fields);
  void add_shell_fields(const StepRecord& record, std::span<const std::string> names, std::vector<FieldValues>& fields);
  void add_rod_fields(const StepRecord& record, std::span<const std::string> names, std::vector<FieldValues>& fields);
  void forget_parts_before(std::int64_t step);
  void with_ghosts(std::vector<double>& owned, std::size_t width);

  Model& model_;
  ShellDrawing shells_;
  ShellFields shell_fields_;
  double time_scale_;  // interval from which velocities of obstacles are computed [s]
  bool is_nodal_;
  Handle<Vec> work_;
  std::optional<PatchRecovery> recovery_;  // if cells are smoothed
  std::vector<char> is_elastic_;
  std::optional<DiscretizationError> mesh_error_;
  std::optional<std::int64_t> step_of_cells_, step_of_nodes_, step_of_parts_;
  std::vector<CellState> cells_, nodes_;
  std::vector<std::optional<std::vector<LayerTriangle>>> triangles_;  // of each shell, at the step of parts
  std::optional<RodState> rods_;                                      // likewise
};

}  // namespace pliant
