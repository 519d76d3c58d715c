/// Every law of viscosity a user can name. A new law is a struct in viscosity.hpp, a place in ViscosityVariant and a
/// row in viscosity_registry.cpp; the tests, the input file and `pliant materials` read the list from here.
#pragma once

#include "material/law_info.hpp"
#include "material/viscosity.hpp"

#include <span>
#include <string_view>

namespace pliant {

/// One row per law, in the order of ViscosityVariant.
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

/// The law of that name; `values` in the order of its row's parameters, `rate` for laws that act on the strain rate.
/// Throws InputError, every mistake at `where`.
ViscosityVariant make_viscosity(std::string_view name, std::span<const double> values, StrainRate rate,
                                const Location& where = {});

}  // namespace pliant
