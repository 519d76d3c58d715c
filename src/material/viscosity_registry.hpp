/// Every law of viscosity a user can name. A new law is a struct in viscosity.hpp, an alternative of ViscosityLaw, and
/// a row and a form in viscosity_registry.cpp: the input's keys with their checks and defaults, its schema, `pliant
/// materials` and the tests follow from these. model/viscosity.cpp maps each law to a term, and does not compile
/// without an entry for every law.
#pragma once

#include "material/law_info.hpp"
#include "material/viscosity.hpp"

#include <span>
#include <string_view>
#include <variant>

namespace pliant {

/// A Maxwell branch whose moduli are relative to the elastic law's at rest.
struct MaxwellRatios {
  static constexpr std::string_view name = Maxwell::name;

  double shear_ratio;      ///< mu_b / mu
  double bulk_ratio;       ///< kappa_b / K
  double relaxation_time;  ///< tau [s]
};

/// A law with its parameters as users give them, in SI units: one alternative for each set of parameters. The form of
/// the strain rate is chosen separately, because it may depend on the time integration method.
using ViscosityLaw = std::variant<KelvinVoigt, StiffnessProportional, MassProportional, Maxwell, MaxwellRatios, Prony>;

std::string_view name_of(const ViscosityLaw& law);

/// Whether the law has a strain rate whose form can be chosen.
bool has_strain_rate(const ViscosityLaw& law);

/// One row per law.
std::span<const LawInfo> viscosity_laws();

/// Gives access to a parameter of a law; the law must be the alternative that has it.
using ViscosityMember = double& (*)(ViscosityLaw&);

/// A set of parameters from which a law is made. The forms of a law differ in their first parameter, which identifies
/// the form that a user chose.
struct ViscosityForm {
  ViscosityLaw blank;                         ///< the alternative, every parameter 0
  std::span<const ParameterInfo> parameters;  ///< those without a fallback are required
  std::span<const ViscosityMember> members;   ///< of the parameters
};

/// One row per alternative of ViscosityLaw, in its order.
std::span<const ViscosityForm> viscosity_forms();

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
