/// Every law of viscosity a user can name. A new law is a struct in viscosity.hpp and a row in viscosity_registry.cpp;
/// the tests, the input file and `pliant materials` read the list from here.
#pragma once

#include "material/law_info.hpp"
#include "material/viscosity.hpp"

#include <span>
#include <string_view>

namespace pliant {

/// One row per law.
std::span<const LawInfo> viscosity_laws();

/// A form of the strain rate as users choose it.
struct StrainRateInfo {
  StrainRate rate;
  std::string_view name;
  std::string_view formula;
  std::string_view when_to_use;
};

/// One row per form, in the order of StrainRate.
std::span<const StrainRateInfo> strain_rates();

}  // namespace pliant
