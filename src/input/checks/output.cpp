#include "input/checks/output.hpp"

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
               is_norm = column.take == FieldColumnConfig::Take::norm;
    if (!of->component && !components.empty() && !is_vector && !is_norm) {
      const std::string field(of->field.name);
      diagnostics.add(column.of.where, "'" + field + "' has " + std::to_string(components.size()) +
                                           " components, of which a column shows one: write " + field + "_" +
                                           components.front() + ", ..., " + field + "_" + components.back() +
                                           ", or `take: norm` for the norm of all");
    }
  }
  check_unique(names, places, "column name", diagnostics);
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
  if (config.contact || given(root, {"contact"}) != nullptr) return;
  const auto need_contact = [&](const std::string& field, const Location& where) {
    if (!field.starts_with("contact_")) return;
    diagnostics.add(where, "the field '" + field + "' needs 'contact', which this input does not have");
  };
  for (std::size_t k = 0; k < places.size() && k < config.output.fields.size(); ++k) {
    need_contact(config.output.fields[k], places[k]);
  }
  for (const FieldColumnConfig& column : config.output.history) need_contact(column.of.value, column.of.where);
}

}  // namespace pliant
