#include "run/recorder.hpp"

#include "base/file.hpp"
#include "base/stopwatch.hpp"
#include "input/input.hpp"
#include "model/rigid_bodies.hpp"
#include "petsc/collective.hpp"
#include "petsc/session.hpp"
#include "run/shell_drawing.hpp"
#include "run/version.hpp"

#include <algorithm>
#include <filesystem>
#include <span>

#include <fmt/format.h>

namespace pliant {
namespace {

/// Starts the output directory; before the writers, so that they find it.
std::filesystem::path prepared_directory(MPI_Comm comm, const Config& config) {
  std::filesystem::path directory = config.output.directory;
  on_root(comm, [&] {
    write_text_atomically(directory / "run.yaml",
                          fmt::format("# The input as understood: defaults and units resolved; can be run again.\n"
                                      "# ranks: {}; PETSc options: {}\n{}{}",
                                      num_ranks(comm), petsc_options(), commented(version_text()), dump(config)));
  });
  return directory;
}

std::vector<OutputGroup> output_groups(const Model& model) {
  const NodeLayout& layout = model.layout();
  const std::int64_t first_cell = row_block(layout.comm, layout.num_owned_cells).first;
  std::vector<OutputGroup> groups;
  for (const MeshGroup& group : model.mesh_groups()) {
    const auto& bodies = model.body_names();
    const bool is_volume = group.dimension == 3;
    if (is_volume && std::ranges::find(bodies, group.name) != bodies.end()) continue;
    groups.push_back({group.name, group.dimension, {}});
    for (const PetscInt n : group.entries) {
      groups.back().entries.push_back(is_volume ? first_cell + n : layout.global_node(n));
    }
  }
  return groups;
}

}  // namespace

OutputMesh output_mesh(const Config& config, const Model& model) {
  const NodeLayout& layout = model.layout();
  OutputMesh mesh;
  mesh.nodes_per_cell = layout.nodes_per_cell;
  mesh.global_num_nodes = layout.num_global_nodes;
  mesh.first_node = layout.first_global_node;
  mesh.coordinates = layout.coordinates;
  ShellDrawing(config, model).place(mesh.coordinates);
  mesh.coordinates.resize(3 * static_cast<std::size_t>(layout.num_owned_nodes));
  for (PetscInt c = 0; c < layout.num_owned_cells; ++c) {
    for (const PetscInt n : layout.nodes_of_cell(c)) mesh.cells.push_back(layout.global_node(n));
    mesh.bodies.push_back(model.body_of_cell()[c]);
  }
  mesh.body_names = model.body_names();
  mesh.masses = names_of_rigid_bodies(config).without_surface;
  const Config completed = with_rigid_bodies(config);
  for (std::size_t b = 0; b < completed.bodies.size(); ++b) {
    const bool is_meshed = completed.bodies[b].is_rigid && !stands_for_body(completed, static_cast<int>(b));
    if (is_meshed) mesh.rigid.push_back(mesh.body_names[b]);
  }
  for (const RodConfig& rod : config.rods) {
    mesh.rods.push_back(rod.name);
    if (rod.section) mesh.rectangular_rods.push_back(rod.name);
  }
  for (const ShellConfig& shell : config.shells) {
    if (shell.is_free) mesh.shells.push_back(shell.name);
  }
  mesh.groups = output_groups(model);
  mesh.sections = names_of_rods(config);
  std::erase_if(mesh.sections,
                [&](const std::string& name) { return std::ranges::find(mesh.rods, name) != mesh.rods.end(); });
  return mesh;
}

Recorder::Recorder(const Config& config, Model& model, const Ledger& ledger, const std::optional<Recorded>& earlier)
    : model_(model),
      row_(config, model, ledger),
      names_(config.output.fields),
      result_(model.layout().comm, prepared_directory(model.layout().comm, config), config.title,
              output_mesh(config, model), earlier ? earlier->last_frame : -1),
      mechanism_drawing_(config, model),
      history_(model.layout().comm, std::filesystem::path(config.output.directory) / "history.csv", row_.columns(),
               earlier ? std::optional(static_cast<double>(earlier->last_row)) : std::nullopt) {
  const std::int64_t last_frame = earlier ? earlier->last_frame : -1;
  if (!mechanism_drawing_.parts().names.empty()) {
    mechanisms_.emplace(model.layout().comm, result_, config.title, mechanism_drawing_.parts(), last_frame);
  }
  if (model.contacts() == nullptr || model.contacts()->num_obstacles() == 0) return;
  drawing_.emplace(*model.contacts(), model.layout());
  obstacles_.emplace(model.layout().comm, result_, config.title, drawing_->surfaces(), last_frame);
}

std::vector<double> Recorder::record(const StepRecord& record, const Ledger& ledger) {
  const Stopwatch watch(seconds_);
  std::vector<double> row = row_.values(record, ledger);
  history_.append(row);
  return row;
}

void Recorder::sync() {
  const Stopwatch watch(seconds_);
  history_.sync();
  result_.sync();
  if (obstacles_) obstacles_->sync();
  if (mechanisms_) mechanisms_->sync();
}

void Recorder::write_frame(const StepRecord& record) {
  const Stopwatch watch(seconds_);
  const NodeLayout& layout = model_.layout();
  const std::vector<FieldValues> values = row_.fields().at(record, names_);
  std::vector<OutputField> fields;
  for (const FieldValues& field : values) {
    const PetscInt rows = field.location == FieldLocation::node ? layout.num_owned_nodes : layout.num_owned_cells;
    fields.push_back({std::string(field.info.name), field.unit, field.location, num_components(field.info.shape),
                      std::span(field.values).first(field.width() * static_cast<std::size_t>(rows))});
  }
  const Instant at = record.instant(model_);
  if (obstacles_) obstacles_->write_frame(record.time, record.step, drawing_->points(at));
  if (mechanisms_) {
    mechanisms_->write_frame(record.time, record.step, mechanism_drawing_.state(at, record.q, record.v));
  }
  result_.write_frame(record.time, record.step, fields);
}

}  // namespace pliant
