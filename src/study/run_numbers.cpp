#include "study/run_numbers.hpp"

#include "base/error.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace pliant {
namespace {

using Column = std::vector<double>;

struct NamedFunction {
  const char* name;
  double (*value)(const Column& time, const Column& values);
};

double largest(const Column&, const Column& y) {
  return *std::ranges::max_element(y);
}
double smallest(const Column&, const Column& y) {
  return *std::ranges::min_element(y);
}

/// By the trapezoidal rule over time.
double mean(const Column& t, const Column& y) {
  if (!(t.back() > t.front())) return y.back();
  double integral = 0.0;
  for (std::size_t i = 1; i < y.size(); ++i) integral += 0.5 * (y[i] + y[i - 1]) * (t[i] - t[i - 1]);
  return integral / (t.back() - t.front());
}

constexpr std::array<NamedFunction, 9> functions{
    {{"max", largest},
     {"min", smallest},
     {"first", [](const Column&, const Column& y) { return y.front(); }},
     {"last", [](const Column&, const Column& y) { return y.back(); }},
     {"mean", mean},
     {"range", [](const Column& t, const Column& y) { return largest(t, y) - smallest(t, y); }},
     {"max_abs", [](const Column& t, const Column& y) { return std::max(largest(t, y), -smallest(t, y)); }},
     {"time_of_max",
      [](const Column& t, const Column& y) {
        return t[static_cast<std::size_t>(std::ranges::max_element(y) - y.begin())];
      }},
     {"time_of_min", [](const Column& t, const Column& y) {
        return t[static_cast<std::size_t>(std::ranges::min_element(y) - y.begin())];
      }}}};

}  // namespace

double RunNumber::of(const HistoryTable& history) const {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  const auto *time = history.find("time"), *values = history.find(column);
  if (time == nullptr || values == nullptr) return none;
  Column t, y;
  for (std::size_t i = 0; i < values->size(); ++i) {
    if (std::isnan((*values)[i])) continue;
    t.push_back((*time)[i]);
    y.push_back((*values)[i]);
  }
  return y.empty() ? none : function(t, y);
}

std::string RunNumber::unit(std::span<const LabelledHistory> histories) const {
  return unit_of_column(histories, is_instant ? "time" : column);
}

RunNumber parse_run_number(const std::string& text, const std::string& option) {
  std::vector<std::string> names;
  for (const NamedFunction& f : functions) names.emplace_back(f.name);
  const auto refuse = [&](const std::string& why) -> InputError {
    return {{option + " " + text, 0, 0},
            fmt::format("{}; expected FUNCTION(COLUMN) or NAME=FUNCTION(COLUMN), e.g. max(tip_z), with one of {}", why,
                        joined(names))};
  };
  RunNumber number;
  const auto open = text.find('('), equals = text.find('=');
  if (open == std::string::npos || trimmed(text).back() != ')') throw refuse("it has no parentheses");
  const bool has_name = equals < open;
  number.name = trimmed(has_name ? std::string_view(text).substr(0, equals) : std::string_view(text));
  const std::size_t begin = has_name ? equals + 1 : 0;
  const std::string function(trimmed(std::string_view(text).substr(begin, open - begin)));
  const std::string_view rest = std::string_view(text).substr(open + 1);
  number.column = trimmed(rest.substr(0, rest.rfind(')')));
  if (number.name.empty() || number.column.empty()) throw refuse("a name is missing");
  const auto same = std::ranges::find(functions, function, &NamedFunction::name);
  if (same == functions.end()) {
    throw refuse(fmt::format("there is no function '{}'{}", function, did_you_mean(function, names)));
  }
  number.function = same->value;
  number.is_instant = function.starts_with("time_of");
  return number;
}

}  // namespace pliant
