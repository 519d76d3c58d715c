#include "input/sections/laws.hpp"

#include "input/formats.hpp"

#include <stdexcept>

namespace pliant {

std::vector<std::string> law_names(std::span<const LawInfo> laws) {
  std::vector<std::string> names;
  for (const LawInfo& law : laws) names.emplace_back(law.name);
  return names;
}

const ParameterInfo& parameter(std::span<const LawInfo> laws, std::string_view name) {
  for (const LawInfo& law : laws) {
    for (const ParameterInfo& p : law.parameters) {
      if (p.name == name) return p;
    }
  }
  throw std::logic_error("no law has the parameter " + std::string(name));
}

Format<double> format_of(const ParameterInfo& p) {
  if (p.upper_bound == UpperBound::included) {
    return quantity(std::string(p.unit), {p.lower, p.upper, Range::Ends::high_included});
  }
  const bool included = p.lower_bound == LowerBound::included;
  return quantity(std::string(p.unit), included ? Range::at_least(p.lower) : Range::between(p.lower, p.upper));
}

}  // namespace pliant
