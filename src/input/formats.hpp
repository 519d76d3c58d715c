/// How single values are typed: numbers with units, words, formulas, parts of the mesh.
#pragma once

#include "base/limits.hpp"
#include "input/schema.hpp"

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace pliant {

/// Admissible values of a number.
struct Range {
  enum class Ends { included, excluded, high_included };
  double low = -infinity;
  double high = infinity;
  Ends ends = Ends::included;

  static Range above(double low) { return {low, infinity, Ends::excluded}; }
  static Range at_least(double low) { return {low, infinity, Ends::included}; }
  static Range between(double low, double high) { return {low, high, Ends::excluded}; }
  static Range from_to(double low, double high) { return {low, high, Ends::included}; }
};

enum class Variables { space, time, space_and_time };

Format<double> quantity(const std::string& unit, const Range& range = {});
/// A number as it stands in formulas of the literature, e.g. 1 - sqrt(2)/2.
Format<double> coefficient();
Format<int> integer(const Range& range);
Format<std::string> text();
/// The name of a surface or volume of the mesh, and where it is given.
Format<Located<std::string>> name_of_part();
Format<Located<std::string>> name_of_probe();
Format<Located<std::string>> path_of_file();
/// true or false
Format<bool> truth();
/// A text that can stand in the header of a CSV column.
Format<std::string> column_name();
/// One of the names; `hint` ends the message about another one, if none is close to it.
Format<std::string> choice(const std::vector<std::string>& names, const std::string& hint = "");
/// A number, a number with a unit, or a formula in SI.
Format<Expression> expression(const std::string& unit, Variables variables);
/// As `expression`, or the word `free` for nothing.
Format<std::optional<Expression>> expression_or_free(const std::string& unit, Variables variables);
/// A direction, of any length except 0.
Format<std::array<double, 3>> direction_of_any_length();
/// A part of the mesh, selected as the kind says.
Format<Selection> selection(Selection::Kind kind);

/// A choice of names that stand for values. `hint`: as of `choice`.
template <class V>
Format<V> choice_of(const std::vector<std::pair<std::string, V>>& values, const std::string& hint = "") {
  std::vector<std::string> names;
  for (const auto& v : values) names.push_back(v.first);
  const Format<std::string> by_name = choice(names, hint);
  Format<V> format{by_name.type, by_name.schema, {}, {}};
  format.read = [values, by_name](const InputNode& node, const std::string& name, Diagnostics& diagnostics, V& into) {
    std::string chosen;
    if (!by_name.read(node, name, diagnostics, chosen)) return false;
    for (const auto& v : values) {
      if (v.first == chosen) into = v.second;
    }
    return true;
  };
  format.write = [values](const V& value) {
    for (const auto& v : values) {
      if (v.second == value) return InputNode::scalar(v.first);
    }
    return InputNode{};
  };
  return format;
}

/// A field for the part of the mesh that an entry refers to; its key is the kind's name.
template <class T>
Field<T> selector(const std::string& key, Selection::Kind kind, const std::string& description) {
  return field(key, &T::part, selection(kind), description);
}

}  // namespace pliant
