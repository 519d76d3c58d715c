/// What users need to know about a law: the rows of the registries of laws.
#pragma once

#include "base/error.hpp"

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace pliant {

enum class LowerBound { excluded, included };
enum class UpperBound { excluded, included };

/// A parameter.
struct ParameterInfo {
  std::string_view name;
  std::string_view unit;  ///< SI; "1" when dimensionless
  double lower;
  double upper;
  std::string_view meaning;
  LowerBound lower_bound = LowerBound::excluded;  ///< whether `lower` itself is admissible
  double typical = 1.0;                           ///< typical of a soft body: for examples, plots and tests
  std::optional<double> fallback = {};            ///< its value if the user does not give it
  UpperBound upper_bound = UpperBound::excluded;  ///< whether `upper` itself is admissible
  std::string_view needed_with = {};              ///< a parameter with which this one has to be given all the same
};

struct LawInfo {
  std::string_view name;
  std::string_view formula;
  std::span<const ParameterInfo> parameters;
  std::string_view source;
  std::string_view when_to_use;
  std::span<const std::string_view> directions = {};  ///< keys of its preferred directions (material/fibre.hpp)
};

/// The admissible values: "> 0", "between -1 and 0.5", "any".
std::string admissible(const ParameterInfo& parameter);

/// What holds if the user does not give it, as the end of a description: "; 0 if not given", "".
std::string fallback_words(const ParameterInfo& parameter);

/// A message if the value of a parameter is not admissible; nullopt if it is.
std::optional<std::string> error_in(const ParameterInfo& parameter, double value);

/// The names of the laws, separated by commas.
std::string names_of(std::span<const LawInfo> laws);

}  // namespace pliant
