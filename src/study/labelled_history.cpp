#include "study/labelled_history.hpp"

#include "input/output_config.hpp"
#include "input/output_fields.hpp"
#include "input/parse.hpp"
#include "run/result_fields.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <sstream>
#include <utility>

#include <fmt/format.h>

namespace pliant {
namespace {

using Take = FieldColumnConfig::Take;

std::string text_at(const InputNode& node, std::initializer_list<std::string_view> path) {
  const InputNode* value = given(node, path);
  return value == nullptr ? std::string() : value->text;
}

Abscissa abscissa_in(const InputNode& input) {
  if (text_at(input, {"time", "method"}) != "static") return Abscissa::time;
  return given(input, {"time", "path"}) != nullptr ? Abscissa::path : Abscissa::load_factor;
}

/// Does any selection of the input choose this surface?
bool is_surface(const InputNode& node, const std::string& name) {
  if (node.key == "surface" && node.text == name) return true;
  return std::ranges::any_of(node.children, [&](const InputNode& child) { return is_surface(child, name); });
}

bool has_entry(const InputNode* list, std::string_view key, const std::string& text) {
  return list != nullptr &&
         std::ranges::any_of(list->children, [&](const InputNode& entry) { return text_at(entry, {key}) == text; });
}

/// The dimension of what a field is integrated over: 3 of volumes, 2 of surfaces, 1 of curves, 0 if the input does not
/// say.
int dimension_of(const InputNode& input, FieldOwner owner, const std::string& in) {
  const InputNode *bodies = given(input, {"bodies"}), *shells = given(input, {"shells"});
  if (owner == FieldOwner::shells) return 2;
  if (owner == FieldOwner::rods) return 1;
  if (in.empty()) return bodies != nullptr ? 3 : shells != nullptr ? 2 : 0;
  if (has_entry(bodies, "volume", in)) return 3;
  if (has_entry(shells, "name", in) || is_surface(input, in)) return 2;
  // Names of volumes are in the mesh alone where a body is all of it.
  return bodies != nullptr && !has_entry(bodies, "volume", "") ? 2 : 0;
}

/// The unit of an integral of a field over so many dimensions, or of the root of that of its square.
std::string unit_of_integral(const std::string& unit, Take take, int dimension) {
  if (dimension == 0) return "";
  const double power = take == Take::norm ? 0.5 * dimension : dimension;
  if (unit == "m") return fmt::format("m^{:g}", 1.0 + power);
  if (unit == "Pa" && power == 2.0) return "N";
  if ((unit == "Pa" && power == 3.0) || (unit == "N/m" && power == 2.0)) return "N m";
  if (unit == "J/m^3" && power == 3.0) return "J";
  const std::string size = power == 1.0 ? "m" : fmt::format("m^{:g}", power);
  return unit.empty() ? size : unit + " " + size;
}

std::vector<FieldColumn> columns_of(const InputNode& input) {
  std::vector<FieldColumn> columns;
  const InputNode* list = given(input, {"output", "history"});
  if (list == nullptr) return columns;
  for (const InputNode& entry : list->children) {
    const std::string take = text_at(entry, {"take"}), of = text_at(entry, {"of"}), in = text_at(entry, {"in"}),
                      at = text_at(entry, {"at"});
    const auto field = field_component(of);
    std::string unit = field ? unit_of_field(field->field.name) : "";
    if (field && at.empty() && (take == "integral" || take == "norm")) {
      unit = unit_of_integral(unit, take == "norm" ? Take::norm : Take::integral,
                              dimension_of(input, field->field.owner, in));
    }
    columns.push_back({text_at(entry, {"name"}),
                       at.empty() ? fmt::format("{} of {}{}", take, of, in.empty() ? "" : " in " + in)
                                  : fmt::format("{} at {}", of, at),
                       std::move(unit)});
  }
  return columns;
}

}  // namespace

std::string axis_label(Abscissa abscissa) {
  switch (abscissa) {
    case Abscissa::load_factor:
      return "load factor";
    case Abscissa::path:
      return "length of the path";
    case Abscissa::time:
      break;
  }
  return "time [s]";
}

std::string instant_text(Abscissa abscissa, double value) {
  return abscissa == Abscissa::time ? fmt::format("t = {:.6g} s", value)
                                    : fmt::format("{} {:.6g}", axis_label(abscissa), value);
}

std::vector<FieldColumn> columns_from_fields(const std::string& input) {
  Diagnostics ignored;
  return columns_of(parse_yaml(input, "run.yaml", ignored));
}

Abscissa abscissa_of(const std::string& input) {
  Diagnostics ignored;
  return abscissa_in(parse_yaml(input, "run.yaml", ignored));
}

std::string LabelledHistory::unit(const std::string& column) const {
  if (column == "time" || column == "dt") return abscissa == Abscissa::time ? "s" : "";
  const auto named = units.find(column);
  if (named != units.end()) return named->second;
  // What a joint moves by says what its laws exert.
  for (const auto& [ending, of_angle, of_travel] :
       {std::array{"_effort", "N m", "N"}, std::array{"_spring", "N m", "N"}, std::array{"_damping", "N m", "N"},
        std::array{"_friction", "N m", "N"}, std::array{"_bearing", "N m", "N"}, std::array{"_stops", "N m", "N"},
        std::array{"_rate", "rad/s", "m/s"}}) {
    if (!column.ends_with(ending)) continue;
    const std::string joint = column.substr(0, column.size() - std::string_view(ending).size());
    if (table.find(joint + "_angle") != nullptr) return of_angle;
    if (table.find(joint + "_travel") != nullptr) return of_travel;
  }
  return std::string(unit_of_column(column));
}

LabelledHistory labelled_history(std::string label, HistoryTable table, const std::string& input) {
  Diagnostics ignored;
  const InputNode root = parse_yaml(input, "run.yaml", ignored);
  LabelledHistory history{std::move(label), std::move(table), abscissa_in(root)};
  for (FieldColumn& column : columns_of(root)) history.units[column.name] = std::move(column.unit);
  return history;
}

LabelledHistory read_labelled_history(std::string label, const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file.parent_path() / "run.yaml").rdbuf();
  return labelled_history(std::move(label), read_history(file), text.str());
}

std::string axis_label(std::span<const LabelledHistory> histories) {
  std::string all;
  for (const LabelledHistory& history : histories) {
    const std::string label = axis_label(history.abscissa);
    if (all.find(label) == std::string::npos) all += (all.empty() ? "" : " or ") + label;
  }
  return all;
}

std::string unit_of_column(std::span<const LabelledHistory> histories, const std::string& column) {
  for (const LabelledHistory& history : histories) {
    if (const std::string unit = history.unit(column); !unit.empty()) return unit;
  }
  return "";
}

std::string with_unit(std::span<const LabelledHistory> histories, const std::string& column) {
  const std::string unit = unit_of_column(histories, column);
  return unit.empty() ? column : fmt::format("{} [{}]", column, unit);
}

}  // namespace pliant
