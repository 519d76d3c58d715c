#include "input/checks/output.hpp"

#include "base/text.hpp"
#include "input/output_fields.hpp"

#include <algorithm>
#include <array>
#include <string_view>

namespace pliant {
namespace {

/// Columns that histories have after the first.
constexpr std::array<std::string_view, 6> further_columns{"numerical_dissipation", "support_work",
                                                          "contact_energy",        "contact_gap_min",
                                                          "contact_points",        "discretization_error"};

bool is_of_history(std::string_view column) {
  return std::ranges::find(first_columns, column) != first_columns.end() ||
         std::ranges::find(further_columns, column) != further_columns.end();
}

std::vector<Location> places_of(const InputNode* list) {
  std::vector<Location> places;
  if (list == nullptr || list->kind != InputNode::Kind::list) return places;
  for (const InputNode& entry : list->children) places.push_back(entry.where);
  return places;
}

void check_columns(const Config& config, const InputNode& root, Diagnostics& diagnostics) {
  const InputNode* list = given(root, {"output", "history"});
  if (list == nullptr || list->kind != InputNode::Kind::list) return;
  std::vector<std::string> names;
  std::vector<Location> places;
  for (std::size_t k = 0; k < config.output.history.size(); ++k) {
    const FieldColumnConfig& column = config.output.history[k];
    const InputNode* name = given(list->children[k], {"name"});
    names.push_back(column.name);
    places.push_back(name != nullptr ? name->where : column.where);
    if (is_of_history(column.name)) {
      diagnostics.add(places.back(), "history.csv has a column '" + column.name + "' of its own; choose another name");
    }
    const auto of = field_component(column.of.value);
    if (!of) continue;  // already an error
    const std::vector<std::string> components = components_of(of->field.shape);
    const bool is_vector = of->field.shape == FieldShape::vector,
               is_norm = !column.at && column.take == FieldColumnConfig::Take::norm;
    if (!of->component && !components.empty() && !is_vector && !is_norm) {
      const std::string field(of->field.name);
      diagnostics.add(column.of.where, "'" + field + "' has " + std::to_string(components.size()) +
                                           " components, of which a column shows one: write " + field + "_" +
                                           components.front() + ", ..., " + field + "_" + components.back() +
                                           (column.at ? "" : ", or `take: norm` for the norm of all"));
    }
  }
  check_unique(names, places, "column name", diagnostics);
}

/// A field that the input asks for, and where.
struct AskedField {
  OutputFieldInfo field;
  const Location& where;
  const FieldColumnConfig* column = nullptr;  ///< none: of the result
};

/// Is there nothing else either, which is an error of its own?
bool is_empty(const Config& config) {
  return config.shells.empty() && config.rods.empty() && config.rigid_bodies.empty();
}

void check_owner(const Config& config, const AskedField& asked, bool has_contact, Diagnostics& diagnostics) {
  const std::string name(asked.field.name);
  const auto need = [&](FieldOwner owner, bool is_there, const char* what) {
    if (asked.field.owner == owner && !is_there) diagnostics.add(asked.where, "the field '" + name + "' " + what);
  };
  need(FieldOwner::contact, has_contact, "needs 'contact', which this input does not have");
  need(FieldOwner::shells, !config.shells.empty(), "needs 'shells', which this input does not have");
  need(FieldOwner::rods, !config.rods.empty(), "needs 'rods', which this input does not have");
  // Stresses are written by default, and zero then.
  const bool needs_bodies =
      asked.field.owner == FieldOwner::bodies && (asked.column != nullptr || name == "discretization_error");
  if (needs_bodies && config.bodies.empty() && !is_empty(config)) {
    diagnostics.add(asked.where,
                    "the field '" + name +
                        "' is of bodies of tetrahedra, and this input has none: fields of shells "
                        "are membrane_force, bending_moment, principal_curvature; fields of rods rod_force, "
                        "rod_bending_moment, rod_torque");
  }
}

/// Names in `in` that the field cannot be taken from.
void check_place(const Config& config, const AskedField& asked, Diagnostics& diagnostics) {
  if (asked.column == nullptr || !asked.column->in) return;
  const Located<std::string>& in = *asked.column->in;
  const std::string field(asked.field.name);
  std::vector<std::string> shells, rods;
  for (const ShellConfig& shell : config.shells) shells.push_back(shell.name);
  for (const RodConfig& rod : config.rods) rods.push_back(rod.name);
  const auto need_one_of = [&](const char* kind, const std::vector<std::string>& names) {
    if (names.empty() || std::ranges::find(names, in.value) != names.end()) return;
    diagnostics.add(in.where, "'" + field + "' is a field of " + kind + "s: 'in' is the name of one, not '" + in.value +
                                  "'" + did_you_mean(in.value, names) + "; the " + kind + "s are: " + joined(names));
  };
  if (asked.field.owner == FieldOwner::shells) need_one_of("shell", shells);
  if (asked.field.owner == FieldOwner::rods) need_one_of("rod", rods);
  const auto shell = std::ranges::find(config.shells, in.value, &ShellConfig::name);
  if (asked.field.owner == FieldOwner::bodies && shell != config.shells.end() && shell->is_free &&
      !config.bodies.empty()) {
    diagnostics.add(in.where, "'" + field + "' is a field of bodies of tetrahedra, and '" + in.value +
                                  "' is a free shell: its fields are membrane_force, bending_moment, "
                                  "principal_curvature");
  }
}

/// A probe that is not there, or where the field is not.
void check_probe(const Config& config, const AskedField& asked, Diagnostics& diagnostics) {
  if (asked.column == nullptr || !asked.column->at) return;
  const Located<std::string>& at = *asked.column->at;
  std::vector<std::string> probes;
  for (const ProbeConfig& probe : config.probes) probes.push_back(probe.name);
  if (std::ranges::find(probes, at.value) == probes.end()) {
    diagnostics.add(at.where,
                    "'at' must be the name of a probe, not '" + at.value + "'" + did_you_mean(at.value, probes) +
                        (probes.empty() ? "; this input has no 'probes'" : "; the probes are: " + joined(probes)));
  }
  if (asked.field.owner == FieldOwner::shells || asked.field.owner == FieldOwner::rods) {
    diagnostics.add(at.where, "'" + std::string(asked.field.name) + "' is a field of " +
                                  (asked.field.owner == FieldOwner::shells ? "shells" : "rods") +
                                  ", which has no value at a probe: use 'in' and 'take'");
  }
}

}  // namespace

void check_unique(const std::vector<std::string>& values, const std::vector<Location>& places, const std::string& what,
                  Diagnostics& diagnostics) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto end = values.begin() + static_cast<std::ptrdiff_t>(i);
    if (values[i].empty() || std::find(values.begin(), end, values[i]) == end) continue;
    diagnostics.add(places[i], "the " + what + " '" + values[i] + "' is given twice");
  }
}

void check_output(const Config& config, const InputNode& root, Diagnostics& diagnostics) {
  const std::vector<Location> places = places_of(given(root, {"output", "fields"}));
  if (places.size() == config.output.fields.size()) check_unique(config.output.fields, places, "field", diagnostics);
  check_columns(config, root, diagnostics);
  const bool has_contact = config.contact || given(root, {"contact"}) != nullptr;
  const auto check = [&](const std::string& name, const Location& where, const FieldColumnConfig* column) {
    const auto of = field_component(name);
    if (!of) return;  // already an error
    const AskedField asked{of->field, where, column};
    check_owner(config, asked, has_contact, diagnostics);
    check_place(config, asked, diagnostics);
    check_probe(config, asked, diagnostics);
  };
  for (std::size_t k = 0; k < places.size() && k < config.output.fields.size(); ++k) {
    check(config.output.fields[k], places[k], nullptr);
  }
  for (const FieldColumnConfig& column : config.output.history) check(column.of.value, column.of.where, &column);
}

}  // namespace pliant
