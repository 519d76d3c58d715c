#include "run/recorder.hpp"

#include "base/file.hpp"
#include "base/stopwatch.hpp"
#include "input/input.hpp"
#include "model/rigid_bodies.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "petsc/ghosted.hpp"
#include "petsc/session.hpp"
#include "run/version.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <numeric>

#include <fmt/format.h>

namespace pliant {
namespace {

/// The parts of a cell's stress, and the quantities that go with them.
struct CellState {
  std::array<std::array<double, 6>, num_stress_parts> cauchy{};
  std::array<double, num_stress_parts> energy_density{};
  double volume_ratio = 1.0;
  double softening = 0.0;

  std::array<double, 6> total_cauchy() const {
    std::array<double, 6> total{};
    for (const auto& part : cauchy) {
      for (std::size_t k = 0; k < total.size(); ++k) total[k] += part[k];
    }
    return total;
  }
};

/// A field per cell.
struct CellResult {
  const char* name;
  const char* unit;
  int components;
  void (*put)(const CellState&, double*);
};

template <StressPart part>
void put_cauchy(const CellState& cell, double* out) {
  std::ranges::copy(cell.cauchy[static_cast<std::size_t>(part)], out);
}
template <StressPart part>
void put_energy(const CellState& cell, double* out) {
  *out = cell.energy_density[static_cast<std::size_t>(part)];
}

constexpr std::array<CellResult, 10> cell_fields{{
    {"cauchy_stress", "Pa", 6, [](const CellState& cell, double* out) { std::ranges::copy(cell.total_cauchy(), out); }},
    {"elastic_cauchy_stress", "Pa", 6, put_cauchy<StressPart::elastic>},
    {"viscous_cauchy_stress", "Pa", 6, put_cauchy<StressPart::viscous>},
    {"active_cauchy_stress", "Pa", 6, put_cauchy<StressPart::active>},
    {"von_mises_stress", "Pa", 1, [](const CellState& cell, double* out) { *out = von_mises(cell.total_cauchy()); }},
    {"volume_ratio", "", 1, [](const CellState& cell, double* out) { *out = cell.volume_ratio; }},
    {"energy_density", "J/m^3", 1,
     [](const CellState& cell, double* out) {
       *out = std::accumulate(cell.energy_density.begin(), cell.energy_density.end(), 0.0);
     }},
    {"elastic_energy_density", "J/m^3", 1, put_energy<StressPart::elastic>},
    {"viscous_energy_density", "J/m^3", 1, put_energy<StressPart::viscous>},
    {"softening", "", 1, [](const CellState& cell, double* out) { *out = cell.softening; }},
}};

struct NodeField {
  const char* name;
  const char* unit;
  Vec StepRecord::*values;
};

constexpr std::array<NodeField, 3> node_fields{{
    {"displacement", "m", &StepRecord::q},
    {"velocity", "m/s", &StepRecord::v},
    {"acceleration", "m/s^2", &StepRecord::a},
}};

/// A field per node, computed from its contact.
struct ContactField {
  const char* name;
  const char* unit;
  int components;
  void (*put)(const NodalContact&, double*);
};

constexpr std::array<ContactField, 3> contact_fields{{
    {"contact_pressure", "Pa", 1, [](const NodalContact& c, double* out) { *out = c.pressure; }},
    {"contact_gap", "m", 1, [](const NodalContact& c, double* out) { *out = c.gap; }},
    {"contact_slip", "m/s", 3,
     [](const NodalContact& c, double* out) { std::copy(c.slip.begin(), c.slip.end(), out); }},
}};

/// The owned cells of a step.
std::vector<CellState> cell_states(Model& model, const StepRecord& record) {
  std::vector<CellState> cells(static_cast<std::size_t>(model.layout().num_owned_cells));
  model.potential().accounts().visit_stresses(model.instant(record.time), record.q, record.v, record.z,
                                              [&](StressPart part, PetscInt cell, const CellStress& stress) {
                                                CellState& state = cells[static_cast<std::size_t>(cell)];
                                                const auto p = static_cast<std::size_t>(part);
                                                for (std::size_t k = 0; k < stress.cauchy.size(); ++k) {
                                                  state.cauchy[p][k] += stress.cauchy[k];
                                                }
                                                state.energy_density[p] += stress.energy_density;
                                                state.softening += stress.softening;
                                                if (part == StressPart::elastic)
                                                  state.volume_ratio = stress.volume_ratio;
                                              });
  return cells;
}

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

}  // namespace

OutputMesh output_mesh(const Config& config, const Model& model) {
  const NodeLayout& layout = model.layout();
  OutputMesh mesh;
  mesh.nodes_per_cell = layout.nodes_per_cell;
  mesh.global_num_nodes = layout.num_global_nodes;
  mesh.first_node = layout.first_global_node;
  mesh.coordinates.assign(layout.coordinates.begin(), layout.coordinates.begin() + 3 * layout.num_owned_nodes);
  for (PetscInt c = 0; c < layout.num_owned_cells; ++c) {
    for (const PetscInt n : layout.nodes_of_cell(c)) mesh.cells.push_back(layout.global_node(n));
    mesh.bodies.push_back(model.body_of_cell()[c]);
  }
  mesh.body_names = model.body_names();
  mesh.masses = names_of_rigid_bodies(config).without_surface;
  for (const RodConfig& rod : config.rods) {
    mesh.rods.push_back(rod.name);
    if (rod.section) mesh.rectangular_rods.push_back(rod.name);
  }
  mesh.sections = names_of_rods(config);
  std::erase_if(mesh.sections,
                [&](const std::string& name) { return std::ranges::find(mesh.rods, name) != mesh.rods.end(); });
  return mesh;
}

Recorder::Recorder(const Config& config, Model& model, const Ledger& ledger, const std::optional<Recorded>& earlier)
    : model_(model),
      row_(config, model, ledger),
      fields_(config.output.fields),
      time_scale_(config.time.step > 0.0 ? config.time.step : 1.0),
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

void Recorder::record(const StepRecord& record, const Ledger& ledger) {
  const Stopwatch watch(seconds_);
  history_.append(row_.values(record, ledger));
}

void Recorder::add_contact_fields(const StepRecord& record, std::vector<std::vector<double>>& storage,
                                  std::vector<OutputField>& fields) {
  const ConstArrayView u(record.q), velocity(record.v);
  const auto nodes = model_.contacts()->at_nodes(model_.instant(record.time), time_scale_, u.span(), velocity.span());
  for (const ContactField& field : contact_fields) {
    if (std::ranges::find(fields_, field.name) == fields_.end()) continue;
    auto& values = storage.emplace_back(field.components * nodes.size(), 0.0);
    for (std::size_t a = 0; a < nodes.size(); ++a) field.put(nodes[a], &values[field.components * a]);
    fields.push_back({field.name, field.unit, FieldLocation::node, field.components, values});
  }
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
  std::vector<std::vector<double>> storage;
  storage.reserve(fields_.size());
  std::vector<OutputField> fields;
  const auto wanted = [&](const char* name) {
    return std::find(fields_.begin(), fields_.end(), name) != fields_.end();
  };

  for (const auto& field : node_fields) {
    if (!wanted(field.name)) continue;
    auto& values = storage.emplace_back(3 * static_cast<std::size_t>(layout.num_owned_nodes), 0.0);
    if (Vec v = record.*field.values; v != nullptr) {
      const ConstArrayView array(v);
      std::copy(array.span().begin(), array.span().end(), values.begin());
    }
    fields.push_back({field.name, field.unit, FieldLocation::node, 3, values});
  }
  if (model_.contacts() != nullptr) add_contact_fields(record, storage, fields);
  if (std::ranges::any_of(cell_fields, [&](const CellResult& field) { return wanted(field.name); })) {
    const std::vector<CellState> cells = cell_states(model_, record);
    for (const auto& field : cell_fields) {
      if (!wanted(field.name)) continue;
      auto& values = storage.emplace_back(field.components * cells.size(), 0.0);
      for (std::size_t c = 0; c < cells.size(); ++c) field.put(cells[c], &values[field.components * c]);
      fields.push_back({field.name, field.unit, FieldLocation::cell, field.components, values});
    }
  }
  const Instant at = model_.instant(record.time);
  if (obstacles_) obstacles_->write_frame(record.time, record.step, drawing_->points(at));
  if (mechanisms_) {
    mechanisms_->write_frame(record.time, record.step, mechanism_drawing_.state(at, record.q, record.v));
  }
  result_.write_frame(record.time, record.step, fields);
}

}  // namespace pliant
