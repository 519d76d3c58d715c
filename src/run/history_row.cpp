#include "run/history_row.hpp"

#include "input/output_fields.hpp"
#include "petsc/collective.hpp"
#include "petsc/ghosted.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include <fmt/format.h>

namespace pliant {
namespace {

using Kind = ContactGroup::Kind;

}  // namespace

HistoryRow::HistoryRow(const Config& config, Model& model, const Ledger& ledger)
    : model_(model),
      fields_(config, model),
      field_columns_(config, model, fields_),
      rigid_states_(config, model),
      static_time_(analysis_of(config) == Analysis::static_equilibrium ? std::optional(config.time.end) : std::nullopt),
      follows_path_(config.time.path.has_value()),
      counts_unstable_modes_(follows_path_ && is_symmetric(model.equation().symmetry())),
      columns_(names_of_columns(config, ledger)) {}

std::vector<std::string> HistoryRow::names_of_columns(const Config& config, const Ledger& ledger) const {
  std::vector<std::string> names(first_columns.begin(), first_columns.end());
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
    if (!support.has_torque()) continue;
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
    if (tendon.friction) names.push_back(tendon.name + "_anchor_tension");
  }
  for (const std::string& spring : model_.springs().names) {
    for (const char* suffix : {"_length", "_force"}) names.push_back(spring + suffix);
  }
  for (const ModelRod& rod : model_.rods().rods) names.push_back(rod.name + "_length");
  for (const auto& probe : config.probes) {
    for (const char* suffix : {"_ux", "_uy", "_uz"}) names.push_back(probe.name + suffix);
  }
  for (const FieldColumnConfig& column : config.output.history) {
    if (std::ranges::find(names, column.name) != names.end()) {
      throw InputError(column.where,
                       fmt::format("history.csv has a column '{}' of its own; choose another name", column.name));
    }
    names.push_back(column.name);
  }
  if (fields_.has_mesh_error()) names.emplace_back("discretization_error");
  if (follows_path_) names.emplace_back("load_factor");
  if (counts_unstable_modes_) names.emplace_back("unstable_modes");
  return names;
}

std::vector<double> HistoryRow::values(const StepRecord& record, const Ledger& ledger) {
  fields_.forget();
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

  const auto [probes, displacements] = probe_states(record);
  row.insert(row.end(), probes.begin(), probes.end());
  for (const auto& [force, torque] : ledger.reactions()) row.insert(row.end(), force.begin(), force.end());
  row.push_back(e.numerical_dissipation);
  row.push_back(e.support_work);
  row.insert(row.end(), e.dissipated_by.begin(), e.dissipated_by.end());
  for (std::size_t s = 0; s < ledger.reactions().size(); ++s) {
    const auto& torque = ledger.reactions()[s].torque;
    if (model_.constraints().supports()[s].has_torque()) row.insert(row.end(), torque.begin(), torque.end());
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
  for (const double number : rigid_states_.values(record.instant(model_), record.q, record.v, ledger.joint_reactions()))
    row.push_back(number);
  for (const double number : tendon_states(record)) row.push_back(number);
  for (const double number : spring_states(record)) row.push_back(number);
  for (const double number : lengths_of_rods(record)) row.push_back(number);
  row.insert(row.end(), displacements.begin(), displacements.end());
  for (const double number : field_columns_.values(record)) row.push_back(number);
  if (fields_.has_mesh_error()) row.push_back(fields_.mesh_error(record).share);
  if (follows_path_) row.push_back(record.load_factor);
  if (counts_unstable_modes_) {
    row.push_back(record.unstable_modes ? static_cast<double>(*record.unstable_modes)
                                        : std::numeric_limits<double>::quiet_NaN());
  }
  return row;
}

std::array<std::vector<double>, 2> HistoryRow::probe_states(const StepRecord& record) {
  if (model_.probes().empty()) return {};
  const ConstGhostedView u(record.q), velocity(record.v);
  std::array<std::vector<double>, 2> values;
  for (const auto& probe : model_.probes()) {
    const auto X = probe.interpolate(model_.layout().coordinates), d = probe.interpolate(u.span()),
               w = probe.interpolate(velocity.span());
    for (std::size_t i = 0; i < 3; ++i) values[0].push_back(X[i] + d[i]);
    values[0].insert(values[0].end(), w.begin(), w.end());
    values[1].insert(values[1].end(), d.begin(), d.end());
  }
  for (auto& numbers : values) sum_in_place(model_.layout().comm, numbers);
  return values;
}

std::vector<double> HistoryRow::cavity_states(const StepRecord& record) {
  std::vector<double> values;
  if (model_.cavities().empty()) return values;
  const ConstGhostedView u(record.q);
  for (const auto& cavity : model_.cavities()) {
    const double swept = sum(model_.layout().comm, cavity.term->swept(u.span()));
    const LoadState at = static_time_ ? LoadState{*static_time_, record.load_factor} : LoadState{record.time, 1.0};
    values.insert(values.end(), {cavity.term->pressure(swept, at), cavity.volume - swept});
  }
  return values;
}

std::vector<double> HistoryRow::tendon_states(const StepRecord& record) {
  std::vector<double> values;
  if (model_.tendons().empty()) return values;
  const ConstGhostedView u(record.q), velocity(record.v);
  const Instant at = record.instant(model_);
  for (const ModelTendon& tendon : model_.tendons()) {
    const double longer = lengthening_of(tendon, model_.layout(), u.span());
    values.insert(values.end(),
                  {tension_at_pulled_end(tendon.drive, longer, at.time, at.load_factor), tendon.length + longer});
    if (tendon.friction) {
      values.push_back(tensions_of(tendon, model_.layout(), u.span(), velocity.span(), at).back());
    }
  }
  return values;
}

std::vector<double> HistoryRow::spring_states(const StepRecord& record) {
  if (model_.springs().names.empty()) return {};
  const ConstGhostedView u(record.q), velocity(record.v);
  return states_of(model_.springs(), model_.layout(), u.span(), velocity.span());
}

std::vector<double> HistoryRow::lengths_of_rods(const StepRecord& record) {
  std::vector<double> lengths;
  if (model_.rods().rods.empty()) return lengths;
  const ConstGhostedView u(record.q);
  for (const ModelRod& rod : model_.rods().rods) {
    const auto places = places_of(rod.points, model_.layout(), u.span());
    double length = 0.0;
    for (std::size_t k = 1; k < places.size(); ++k) length += norm(places[k] - places[k - 1]);
    lengths.push_back(length);
  }
  return lengths;
}

double HistoryRow::contact_energy(const StepRecord& record) {
  const ConstGhostedView u(record.q);
  return sum(model_.layout().comm, model_.contacts()->energy(record.instant(model_), u.span()));
}

}  // namespace pliant
