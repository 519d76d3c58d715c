#include "material/law_info.hpp"

#include "base/limits.hpp"

#include <cmath>

#include <fmt/format.h>

namespace pliant {

std::string admissible(const ParameterInfo& p) {
  const bool has_lower = p.lower > -infinity, has_upper = p.upper < infinity;
  if (has_lower && has_upper) return fmt::format("between {} and {}", p.lower, p.upper);
  if (has_lower) return fmt::format("{} {}", p.lower_bound == LowerBound::included ? ">=" : ">", p.lower);
  return has_upper ? fmt::format("< {}", p.upper) : "any";
}

std::string fallback_words(const ParameterInfo& p) {
  if (!p.fallback) return "";
  return p.needed_with.empty() ? fmt::format("; {:g} if not given", *p.fallback)
                               : fmt::format("; left out with {}", p.needed_with);
}

std::optional<std::string> error_in(const ParameterInfo& parameter, double value) {
  const bool may_be_lower = parameter.lower_bound == LowerBound::included;
  const bool is_above = may_be_lower ? value >= parameter.lower : value > parameter.lower;
  const bool may_be_upper = parameter.upper_bound == UpperBound::included;
  if (is_above && (value < parameter.upper || (may_be_upper && value == parameter.upper))) return std::nullopt;
  const std::string range = parameter.upper < infinity
                                ? fmt::format("between {} and {}, {} excluded", parameter.lower, parameter.upper,
                                              may_be_upper   ? "the former"
                                              : may_be_lower ? "the latter"
                                                             : "both")
                                : fmt::format("finite and {} {}", may_be_lower ? "at least" : "above", parameter.lower);
  return fmt::format("{} is {}; it must be {}", parameter.name, value, range);
}

std::string names_of(std::span<const LawInfo> laws) {
  std::string names;
  for (const auto& law : laws) names += (names.empty() ? "" : ", ") + std::string(law.name);
  return names;
}

}  // namespace pliant
