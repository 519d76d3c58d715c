#include "input/formats.hpp"

#include "base/text.hpp"
#include "base/units.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace pliant {
namespace {

using Json = nlohmann::ordered_json;

JsonSchema shared(Json schema) {
  return std::make_shared<Json>(std::move(schema));
}

bool contains(const Range& range, double value) {
  const bool is_above = range.ends == Range::Ends::included ? value >= range.low : value > range.low;
  return is_above && (range.ends == Range::Ends::excluded ? value < range.high : value <= range.high);
}

/// "> 0", ">= 0", "between -1 and 0.5", "from 0 to 6"; empty if everything is admissible.
std::string in_words(const Range& range) {
  const bool included = range.ends == Range::Ends::included;
  const std::string low = format_number(range.low);
  const std::string high = format_number(range.high);
  if (range.ends == Range::Ends::high_included) return "between " + low + " (excluded) and " + high;
  if (std::isfinite(range.high))
    return included ? "from " + low + " to " + high : "between " + low + " and " + high + " (both excluded)";
  if (std::isfinite(range.low)) return (included ? ">= " : "> ") + low;
  return "";
}

Json json_number(double value) {
  return std::trunc(value) == value ? Json(static_cast<long>(value)) : Json(value);
}

Json with_limits(Json schema, const Range& range) {
  const bool low_included = range.ends == Range::Ends::included, high_included = range.ends != Range::Ends::excluded;
  if (std::isfinite(range.low)) schema[low_included ? "minimum" : "exclusiveMinimum"] = json_number(range.low);
  if (std::isfinite(range.high)) schema[high_included ? "maximum" : "exclusiveMaximum"] = json_number(range.high);
  return schema;
}

/// "pressure [Pa]" without the article.
std::string noun(const std::string& unit) {
  const std::string name = quantity_name(unit);
  return name.substr(name.find(' ') + 1);
}

bool read_quantity(const InputNode& node, const std::string& name, const std::string& unit, Diagnostics& diagnostics,
                   double& into) {
  if (node.kind != InputNode::Kind::scalar) return refuse(node, name, quantity_name(unit), diagnostics);
  try {
    into = parse_quantity(node.text, unit);
    return true;
  } catch (const UnitError& error) {
    diagnostics.add(node.where, "'" + name + "': " + error.what());
    return false;
  }
}

/// The place of a character of a text; only texts on one line can be followed.
Location place_in(const InputNode& node, int position) {
  Location where = node.where;
  if (where.line > 0 && node.text.find('\n') == std::string::npos) {
    where.column += position + (node.style == InputNode::Style::quoted ? 1 : 0);
  }
  return where;
}

/// How a product of a quantity and a formula, such as '5 mm*sin(t)', is written.
std::string in_si(const std::string& text, const std::string& unit) {
  for (std::size_t at = text.find('*'); at != std::string::npos; at = text.find('*', at + 1)) {
    try {
      const double factor = parse_quantity(text.substr(0, at), unit);
      const Expression rest(text.substr(at + 1));
      return std::string(rest.depends_on_time() ? ", where t is the time, and in a unit the tonne" : "") + ": write " +
             format_number(factor) + "*" + std::string(trimmed(rest.text()));
    } catch (const std::runtime_error&) {
      continue;  // the unit has a '*' itself
    }
  }
  return "; products need '*'";
}

bool read_expression(const InputNode& node, const std::string& name, const std::string& unit, Diagnostics& diagnostics,
                     Expression& into) {
  if (node.kind != InputNode::Kind::scalar) {
    return refuse(node, name, quantity_name(unit) + " or a formula", diagnostics);
  }
  try {
    into = looks_like_quantity(node.text) ? Expression(parse_quantity(node.text, unit)) : Expression(node.text);
  } catch (const UnitError& error) {
    diagnostics.add(node.where, "'" + name + "': " + error.what() + " (formulas are in SI without units" +
                                    in_si(node.text, unit) + ")");
    return false;
  } catch (const ExpressionError& error) {
    const bool is_split = node.style == InputNode::Style::plain && is_part_of_formula(node.text);
    diagnostics.add(
        place_in(node, error.position()),
        "'" + name + "': " + error.what() +
            (is_split ? " (inside [ ] and { }, put a formula with a ',' in quotes, such as \"min(t, 1)\")" : ""));
    return false;
  }
  const bool is_constant = !into.depends_on_space() && !into.depends_on_time();
  if (is_constant && !std::isfinite(into(0, 0, 0, 0))) {
    return refuse(node, name, "finite", diagnostics);
  }
  return true;
}

bool check_variables(const Expression& e, Variables variables, const InputNode& node, const std::string& name,
                     Diagnostics& diagnostics) {
  if (variables == Variables::space && e.depends_on_time()) {
    diagnostics.add(node.where, "'" + name + "' cannot depend on the time t; it is a function of x, y, z");
    return false;
  }
  if (variables == Variables::time && e.depends_on_space()) {
    diagnostics.add(node.where, "'" + name + "' cannot depend on the position x, y, z; it is a function of t");
    return false;
  }
  return true;
}

InputNode written(const Expression& e) {
  InputNode node = InputNode::scalar(e.text());
  if (!parse_number(node.text)) node.style = InputNode::Style::quoted;
  return node;
}

Format<Selection> box_selection() {
  const auto corners = array_of<2>(array_of<3>(quantity("m")));
  Format<Selection> format{"two opposite corners, [[x, y, z], [x, y, z]] [m]", corners.schema, {}, {}};
  format.read = [corners](const InputNode& node, const std::string& name, Diagnostics& diagnostics, Selection& into) {
    std::array<std::array<double, 3>, 2> c{};
    if (!corners.read(node, name, diagnostics, c)) return false;
    for (std::size_t i = 0; i < 3; ++i) {
      if (c[0][i] > c[1][i]) return refuse(node, name, "the lower corner, then the upper corner", diagnostics);
      into.box[i] = c[0][i];
      into.box[3 + i] = c[1][i];
    }
    return true;
  };
  format.write = [corners](const Selection& s) {
    return corners.write({{{s.box[0], s.box[1], s.box[2]}, {s.box[3], s.box[4], s.box[5]}}});
  };
  return format;
}

Format<Selection> region_selection() {
  const auto region = expression("1", Variables::space);
  Format<Selection> format{"condition on x, y, z [m], such as \"x < 1e-9\"", region.schema, {}, {}};
  format.read = [region](const InputNode& node, const std::string& name, Diagnostics& diagnostics, Selection& into) {
    return region.read(node, name, diagnostics, into.region.emplace());
  };
  format.write = [region](const Selection& s) { return region.write(*s.region); };
  return format;
}

Format<Selection> named_selection() {
  const auto group = text();
  Format<Selection> format{"name or tag of a physical group", shared({{"type", {"string", "integer"}}}), {}, {}};
  format.read = [group](const InputNode& node, const std::string& name, Diagnostics& diagnostics, Selection& into) {
    const bool empty = node.kind == InputNode::Kind::scalar && node.text.empty();
    if (empty) return refuse(node, name, "the name or tag of a physical group", diagnostics);
    return group.read(node, name, diagnostics, into.name);
  };
  format.write = [group](const Selection& s) { return group.write(s.name); };
  return format;
}

}  // namespace

Format<double> quantity(const std::string& unit, const Range& range) {
  const std::string limits = in_words(range);
  Json schema{{"anyOf", Json::array({with_limits({{"type", "number"}}, range), {{"type", "string"}}})}};
  Format<double> format{noun(unit) + (limits.empty() ? "" : ", " + limits), shared(std::move(schema)), {}, {}};
  format.read = [unit, range, limits](const InputNode& node, const std::string& name, Diagnostics& diagnostics,
                                      double& into) {
    if (!read_quantity(node, name, unit, diagnostics, into)) return false;
    return contains(range, into) || refuse(node, name, limits + (unit == "1" ? "" : " [" + unit + "]"), diagnostics);
  };
  format.write = [](double value) { return InputNode::scalar(format_number(value)); };
  return format;
}

Format<double> coefficient() {
  Format<double> format{"number or formula of numbers", shared({{"type", {"number", "string"}}}), {}, {}};
  format.read = [type = format.type](const InputNode& node, const std::string& name, Diagnostics& diagnostics,
                                     double& into) {
    Expression value;
    if (!read_expression(node, name, "1", diagnostics, value)) return false;
    if (value.depends_on_space() || value.depends_on_time()) return refuse(node, name, "a " + type, diagnostics);
    into = value(0, 0, 0, 0);
    return true;
  };
  format.write = [](double value) { return InputNode::scalar(format_number(value)); };
  return format;
}

Format<int> integer(const Range& range) {
  const std::string type = "whole number " + in_words(range);
  Format<int> format{type, shared(with_limits({{"type", "integer"}}, range)), {}, {}};
  format.read = [type, range](const InputNode& node, const std::string& name, Diagnostics& diagnostics, int& into) {
    constexpr double largest = std::numeric_limits<int>::max();
    const auto number = node.kind == InputNode::Kind::scalar ? parse_number(node.text) : std::nullopt;
    if (!number || std::trunc(*number) != *number || !contains(range, *number) || std::abs(*number) > largest) {
      return refuse(node, name, "a " + type, diagnostics);
    }
    into = static_cast<int>(*number);
    return true;
  };
  format.write = [](int value) { return InputNode::scalar(std::to_string(value)); };
  return format;
}

namespace {

Format<Located<std::string>> located_text(const std::string& what) {
  const auto name = text();
  Format<Located<std::string>> format{what, name.schema, {}, {}};
  format.read = [name](const InputNode& node, const std::string& key, Diagnostics& diagnostics,
                       Located<std::string>& into) {
    into.where = node.where;
    return name.read(node, key, diagnostics, into.value);
  };
  format.write = [name](const Located<std::string>& value) { return name.write(value.value); };
  return format;
}

}  // namespace

Format<Located<std::string>> name_of_part() {
  return located_text("name of a physical surface or volume");
}

Format<Located<std::string>> name_of_probe() {
  return located_text("name of a probe");
}

Format<Located<std::string>> path_of_file() {
  return located_text("path of a file");
}

Format<bool> truth() {
  Format<bool> format{"`true` or `false`", shared({{"enum", {true, false, "true", "false"}}}), {}, {}};
  format.read = [](const InputNode& node, const std::string& name, Diagnostics& diagnostics, bool& into) {
    if (node.kind != InputNode::Kind::scalar || (node.text != "true" && node.text != "false")) {
      return refuse(node, name, "true or false", diagnostics);
    }
    into = node.text == "true";
    return true;
  };
  format.write = [](bool value) {
    InputNode word = InputNode::scalar(value ? "true" : "false");
    word.style = InputNode::Style::word;
    return word;
  };
  return format;
}

Format<std::string> text() {
  Format<std::string> format{"text", shared({{"type", {"string", "number"}}, {"minLength", 1}}), {}, {}};
  format.read = [](const InputNode& node, const std::string& name, Diagnostics& diagnostics, std::string& into) {
    if (node.kind != InputNode::Kind::scalar || node.text.empty()) return refuse(node, name, "text", diagnostics);
    into = node.text;
    return true;
  };
  format.write = [](const std::string& value) {
    if (value.empty()) return InputNode{};
    InputNode node = InputNode::scalar(value);
    return node;
  };
  return format;
}

Format<std::string> column_name() {
  Format<std::string> format = text();
  format.type = "name without commas, quotes or line breaks";
  format.read = [read = format.read, type = format.type](const InputNode& node, const std::string& name,
                                                         Diagnostics& diagnostics, std::string& into) {
    if (!read(node, name, diagnostics, into)) return false;
    const bool good = trimmed(into) == into && into.find_first_of(",;\"'\t\r\n") == std::string::npos;
    return good || refuse(node, name, "a " + type, diagnostics);
  };
  return format;
}

Format<std::string> choice(const std::vector<std::string>& names, const std::string& hint) {
  Format<std::string> format{"one of " + joined(names), shared({{"enum", names}}), {}, {}};
  format.read = [names, hint](const InputNode& node, const std::string& name, Diagnostics& diagnostics,
                              std::string& into) {
    if (std::find(names.begin(), names.end(), node.text) != names.end() && node.kind == InputNode::Kind::scalar) {
      into = node.text;
      return true;
    }
    const std::string wanted = names.size() == 1 ? "'" + names.front() + "'" : "one of " + joined(names);
    const std::string meant = did_you_mean(node.text, names);
    diagnostics.add(node.place(),
                    "'" + name + "' must be " + wanted + ", not " + description(node) + (meant.empty() ? hint : meant));
    return false;
  };
  format.write = [](const std::string& value) { return value.empty() ? InputNode{} : InputNode::scalar(value); };
  return format;
}

Format<Expression> expression(const std::string& unit, Variables variables) {
  const std::string arguments = variables == Variables::space  ? "x, y, z"
                                : variables == Variables::time ? "t"
                                                               : "x, y, z, t";
  Format<Expression> format{
      noun(unit) + " or formula of " + arguments, shared({{"type", {"number", "string"}}}), {}, {}};
  format.read = [unit, variables](const InputNode& node, const std::string& name, Diagnostics& diagnostics,
                                  Expression& into) {
    return read_expression(node, name, unit, diagnostics, into) &&
           check_variables(into, variables, node, name, diagnostics);
  };
  format.write = written;
  return format;
}

Format<std::optional<Expression>> expression_or_free(const std::string& unit, Variables variables) {
  const auto value = expression(unit, variables);
  Format<std::optional<Expression>> format{value.type + ", or `free`", value.schema, {}, {}};
  format.read = [value, unit](const InputNode& node, const std::string& name, Diagnostics& diagnostics,
                              std::optional<Expression>& into) {
    if (node.kind == InputNode::Kind::scalar && node.text == "free") {
      into.reset();
      return true;
    }
    if (node.kind == InputNode::Kind::null || node.text == "-") {
      return refuse(node, name, quantity_name(unit) + " or a formula (what is not prescribed is written `free`)",
                    diagnostics);
    }
    return value.read(node, name, diagnostics, into.emplace());
  };
  format.write = [value](const std::optional<Expression>& e) {
    return e ? value.write(*e) : InputNode::scalar("free");
  };
  return format;
}

Format<std::array<double, 3>> direction_of_any_length() {
  Format<std::array<double, 3>> format = array_of<3>(quantity("1"));
  format.type = "direction [x, y, z], of any length";
  format.read = [read = format.read](const InputNode& node, const std::string& name, Diagnostics& diagnostics,
                                     std::array<double, 3>& into) {
    if (!read(node, name, diagnostics, into)) return false;
    const bool is_zero = std::ranges::all_of(into, [](double x) { return x == 0.0; });
    if (is_zero) diagnostics.add(node.where, "'" + name + "' must have a length; [0, 0, 0] points nowhere");
    return !is_zero;
  };
  return format;
}

Format<Selection> selection(Selection::Kind kind) {
  Format<Selection> format = kind == Selection::Kind::box     ? box_selection()
                             : kind == Selection::Kind::where ? region_selection()
                                                              : named_selection();
  format.read = [kind, read = format.read](const InputNode& node, const std::string& name, Diagnostics& diagnostics,
                                           Selection& into) {
    into.kind = kind;
    into.where = node.where;
    if (kind == Selection::Kind::point && node.kind == InputNode::Kind::list) {
      diagnostics.add(node.where,
                      "'" + name +
                          "' must be the name or tag of a physical group of points (in gmsh: Physical "
                          "Point), not a place [x, y, z]; 'box' or 'where' select the surface near a place");
      return false;
    }
    return read(node, name, diagnostics, into);
  };
  format.write = [kind, write = format.write](const Selection& s) { return s.kind == kind ? write(s) : InputNode{}; };
  return format;
}

}  // namespace pliant
