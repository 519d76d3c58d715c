#include "study/labelled_history.hpp"

#include "input/output_fields.hpp"
#include "input/parse.hpp"
#include "run/result_fields.hpp"

#include <fstream>
#include <sstream>
#include <utility>

#include <fmt/format.h>

namespace pliant {
namespace {

std::string text_at(const InputNode& node, std::initializer_list<std::string_view> path) {
  const InputNode* value = given(node, path);
  return value == nullptr ? std::string() : value->text;
}

Abscissa abscissa_in(const InputNode& input) {
  if (text_at(input, {"time", "method"}) != "static") return Abscissa::time;
  return given(input, {"time", "path"}) != nullptr ? Abscissa::path : Abscissa::load_factor;
}

std::vector<FieldColumn> columns_of(const InputNode& input) {
  std::vector<FieldColumn> columns;
  const InputNode* list = given(input, {"output", "history"});
  if (list == nullptr) return columns;
  for (const InputNode& entry : list->children) {
    const std::string take = text_at(entry, {"take"}), of = text_at(entry, {"of"}), in = text_at(entry, {"in"}),
                      at = text_at(entry, {"at"});
    const auto field = field_component(of);
    // Others have a power of the metre.
    const bool is_field_itself = !at.empty() || take == "max" || take == "min" || take == "mean";
    columns.push_back({text_at(entry, {"name"}),
                       at.empty() ? fmt::format("{} of {}{}", take, of, in.empty() ? "" : " in " + in)
                                  : fmt::format("{} at {}", of, at),
                       field && is_field_itself ? unit_of_field(field->field.name) : ""});
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
  return named != units.end() ? named->second : std::string(unit_of_column(column));
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
