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

using Kind = ContactGroup::Kind;

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
  return mesh;
}

Recorder::Recorder(const Config& config, Model& model, const Ledger& ledger, const std::optional<Recorded>& earlier)
    : model_(model),
      rigid_states_(config, model),
      fields_(config.output.fields),
      time_scale_(config.time.step > 0.0 ? config.time.step : 1.0),
      static_time_(analysis_of(config) == Analysis::static_equilibrium ? std::optional(config.time.end) : std::nullopt),
      result_(model.layout().comm, prepared_directory(model.layout().comm, config), config.title,
              output_mesh(config, model), earlier ? earlier->last_frame : -1),
      mechanism_drawing_(config, model),
      history_(model.layout().comm, std::filesystem::path(config.output.directory) / "history.csv",
               columns(config, ledger), earlier ? std::optional(static_cast<double>(earlier->last_row)) : std::nullopt),
      q_(make_vector(model.layout())),
      v_(make_vector(model.layout())) {
  const std::int64_t last_frame = earlier ? earlier->last_frame : -1;
  if (!mechanism_drawing_.parts().names.empty()) {
    mechanisms_.emplace(model.layout().comm, result_, config.title, mechanism_drawing_.parts(), last_frame);
  }
  if (model.contacts() == nullptr || model.contacts()->num_obstacles() == 0) return;
  drawing_.emplace(*model.contacts(), model.layout());
  obstacles_.emplace(model.layout().comm, result_, config.title, drawing_->surfaces(), last_frame);
}

std::vector<std::string> Recorder::columns(const Config& config, const Ledger& ledger) const {
  std::vector<std::string> names{"step",
                                 "time",
                                 "dt",
                                 "newton_iterations",
                                 "linear_iterations",
                                 "kinetic_energy",
                                 "elastic_energy",
                                 "load_potential",
                                 "dissipated_energy",
                                 "load_work",
                                 "energy_balance_error",
                                 "px",
                                 "py",
                                 "pz",
                                 "Lx",
                                 "Ly",
                                 "Lz"};
  const Contacts* contacts = model_.contacts();
  const auto add_columns = [&](Kind kind, const std::array<const char*, 3>& suffixes) {
    if (contacts == nullptr) return;
    for (const ContactGroup& group : contacts->groups()) {
      if (group.kind != kind) continue;
      for (const char* suffix : suffixes) names.push_back(group.name + suffix);
    }
  };
  constexpr std::array force_suffixes{"_fx", "_fy", "_fz"}, impulse_suffixes{"_jx", "_jy", "_jz"};
  add_columns(Kind::obstacle, force_suffixes);
  for (const auto& probe : config.probes) {
    for (const char* suffix : {"_x", "_y", "_z", "_vx", "_vy", "_vz"}) names.push_back(probe.name + suffix);
  }
  for (const auto& support : model_.constraints().supports()) {
    for (const char* suffix : {"_fx", "_fy", "_fz"}) names.push_back(support.name + suffix);
  }
  for (const char* name : {"numerical_dissipation", "support_work"}) names.emplace_back(name);
  for (std::string mechanism : ledger.mechanisms()) {
    std::ranges::replace(mechanism, '-', '_');
    names.push_back("dissipated_" + mechanism);
  }
  for (const auto& support : model_.constraints().supports()) {
    if (!support.rigid_part) continue;
    for (const char* suffix : {"_tx", "_ty", "_tz"}) names.push_back(support.name + suffix);
  }
  for (const auto& cavity : model_.cavities()) {
    for (const char* suffix : {"_pressure", "_volume"}) names.push_back(cavity.name + suffix);
  }
  if (contacts != nullptr) {
    names.emplace_back("contact_energy");
    add_columns(Kind::obstacle, impulse_suffixes);
    add_columns(Kind::obstacle_on_body, force_suffixes);
    add_columns(Kind::bodies, force_suffixes);
    add_columns(Kind::bodies, impulse_suffixes);
    for (const char* name : {"contact_gap_min", "contact_points"}) names.emplace_back(name);
  }
  for (std::string& name : rigid_states_.columns()) names.push_back(std::move(name));
  for (const ModelTendon& tendon : model_.tendons()) {
    for (const char* suffix : {"_tension", "_length"}) names.push_back(tendon.name + suffix);
  }
  for (const std::string& spring : model_.springs().names) {
    for (const char* suffix : {"_length", "_force"}) names.push_back(spring + suffix);
  }
  return names;
}

void Recorder::record(const StepRecord& record, const Ledger& ledger) {
  const Stopwatch watch(seconds_);
  const Energies& e = ledger.energies();
  std::vector<double> row{static_cast<double>(record.step),
                          record.time,
                          record.dt,
                          static_cast<double>(record.newton_iterations),
                          static_cast<double>(record.linear_iterations),
                          e.kinetic,
                          e.elastic,
                          e.load_potential,
                          e.dissipated,
                          e.load_work,
                          e.balance_error};
  row.insert(row.end(), e.momenta.linear.begin(), e.momenta.linear.end());
  row.insert(row.end(), e.momenta.angular.begin(), e.momenta.angular.end());
  const auto add_contacts = [&](Kind kind, std::array<double, 3> ContactForce::*numbers) {
    if (model_.contacts() == nullptr) return;
    for (std::size_t c = 0; c < ledger.contacts().size(); ++c) {
      if (model_.contacts()->groups()[c].kind != kind) continue;
      const auto& values = ledger.contacts()[c].*numbers;
      row.insert(row.end(), values.begin(), values.end());
    }
  };
  add_contacts(Kind::obstacle, &ContactForce::force);

  if (!model_.probes().empty()) {
    check(VecCopy(record.q, q_.get()));
    check(VecCopy(record.v, v_.get()));
    update_ghosts(q_.get());
    update_ghosts(v_.get());
    const ConstGhostedView u(q_.get()), velocity(v_.get());
    std::vector<double> values;
    for (const auto& probe : model_.probes()) {
      const auto X = probe.interpolate(model_.layout().coordinates), d = probe.interpolate(u.span()),
                 w = probe.interpolate(velocity.span());
      for (int i = 0; i < 3; ++i) values.push_back(X[i] + d[i]);
      values.insert(values.end(), w.begin(), w.end());
    }
    check_mpi(MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_DOUBLE, MPI_SUM,
                            model_.layout().comm));
    row.insert(row.end(), values.begin(), values.end());
  }
  for (const auto& [force, torque] : ledger.reactions()) row.insert(row.end(), force.begin(), force.end());
  row.push_back(e.numerical_dissipation);
  row.push_back(e.support_work);
  row.insert(row.end(), e.dissipated_by.begin(), e.dissipated_by.end());
  for (std::size_t s = 0; s < ledger.reactions().size(); ++s) {
    const auto& torque = ledger.reactions()[s].torque;
    if (model_.constraints().supports()[s].rigid_part) row.insert(row.end(), torque.begin(), torque.end());
  }
  for (const double value : cavity_states(record)) row.push_back(value);
  if (model_.contacts() != nullptr) {
    row.push_back(contact_energy(record));
    add_contacts(Kind::obstacle, &ContactForce::impulse);
    add_contacts(Kind::obstacle_on_body, &ContactForce::force);
    add_contacts(Kind::bodies, &ContactForce::force);
    add_contacts(Kind::bodies, &ContactForce::impulse);
    row.insert(row.end(), {record.contact.gap, record.contact.num_points});
  }
  for (const double number :
       rigid_states_.values(model_.instant(record.time), record.q, record.v, ledger.joint_reactions()))
    row.push_back(number);
  for (const double number : tendon_states(record)) row.push_back(number);
  for (const double number : spring_states(record)) row.push_back(number);
  history_.append(row);
}

std::vector<double> Recorder::cavity_states(const StepRecord& record) {
  std::vector<double> values;
  if (model_.cavities().empty()) return values;
  check(VecCopy(record.q, q_.get()));
  update_ghosts(q_.get());
  const ConstGhostedView u(q_.get());
  for (const auto& cavity : model_.cavities()) {
    const double swept = sum(model_.layout().comm, cavity.term->swept(u.span()));
    const LoadState at = static_time_ ? LoadState{*static_time_, record.time} : LoadState{record.time, 1.0};
    values.insert(values.end(), {cavity.term->pressure(swept, at), cavity.volume - swept});
  }
  return values;
}

std::vector<double> Recorder::tendon_states(const StepRecord& record) {
  std::vector<double> values;
  if (model_.tendons().empty()) return values;
  check(VecCopy(record.q, q_.get()));
  update_ghosts(q_.get());
  const ConstGhostedView u(q_.get());
  const Instant at = model_.instant(record.time);
  for (const ModelTendon& tendon : model_.tendons()) {
    const double longer = lengthening_of(tendon, model_.layout(), u.span());
    values.insert(values.end(),
                  {tension_at_pulled_end(tendon.drive, longer, at.time, at.load_factor), tendon.length + longer});
  }
  return values;
}

std::vector<double> Recorder::spring_states(const StepRecord& record) {
  if (model_.springs().names.empty()) return {};
  check(VecCopy(record.q, q_.get()));
  check(VecCopy(record.v, v_.get()));
  update_ghosts(q_.get());
  update_ghosts(v_.get());
  const ConstGhostedView u(q_.get()), velocity(v_.get());
  return states_of(model_.springs(), model_.layout(), u.span(), velocity.span());
}

double Recorder::contact_energy(const StepRecord& record) {
  check(VecCopy(record.q, q_.get()));
  update_ghosts(q_.get());
  const ConstGhostedView u(q_.get());
  return sum(model_.layout().comm, model_.contacts()->energy(model_.instant(record.time), u.span()));
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
