/// Keys of the input that are parameters of laws: what the laws' registries say of them becomes their description.
#pragma once

#include "input/schema.hpp"
#include "material/law_info.hpp"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace pliant {

std::vector<std::string> law_names(std::span<const LawInfo> laws);

/// A parameter as the laws' registry describes it; several laws may have one of that name, the first counts.
const ParameterInfo& parameter(std::span<const LawInfo> laws, std::string_view name);

Format<double> format_of(const ParameterInfo& p);

/// The key of that parameter.
template <class T>
Field<T> law_field(std::span<const LawInfo> laws, double T::*member, std::string_view name) {
  const ParameterInfo& p = parameter(laws, name);
  return field(std::string(name), member, format_of(p), std::string(p.meaning));
}

}  // namespace pliant
