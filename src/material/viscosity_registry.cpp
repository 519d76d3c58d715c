#include "material/viscosity_registry.hpp"

#include <array>
#include <cassert>
#include <limits>
#include <vector>

#include <fmt/format.h>

namespace pliant {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

constexpr std::array kelvin_voigt{
    ParameterInfo{"shear", "Pa*s", 0.0, infinity, "viscosity against change of shape", LowerBound::included},
    ParameterInfo{"bulk", "Pa*s", 0.0, infinity, "viscosity against change of volume", LowerBound::included},
};

constexpr std::array maxwell{
    ParameterInfo{"shear_modulus", "Pa", 0.0, infinity, "stiffness of the branch's spring against fast change of shape",
                  LowerBound::included},
    ParameterInfo{"bulk_modulus", "Pa", 0.0, infinity, "stiffness of the branch's spring against fast change of volume",
                  LowerBound::included},
    ParameterInfo{"relaxation_time", "s", 0.0, infinity, "time in which the branch's stress falls to 1/e"},
};

constexpr std::array<LawInfo, std::variant_size_v<ViscosityVariant>> laws{{
    {KelvinVoigt::name, "R = shear dev(Edot):dev(Edot) + bulk/2 (tr Edot)^2, E = (F^T F - I)/2", kelvin_voigt,
     "Landau & Lifshitz, Theory of Elasticity (1986), section 34, with E for the small strain",
     "damping that grows with frequency: the damping ratio of a mode w is (viscosity/stiffness) w / 2; take some of it "
     "when an accurate time method shows vibrations that the real body does not have"},
    {Maxwell::name,
     "psi = shear_modulus dev(E-G):dev(E-G) + bulk_modulus/2 (tr(E-G))^2, Gdot = (E - G)/relaxation_time", maxwell,
     "Holzapfel, Nonlinear Solid Mechanics (2000), section 6.10; Kumar & Lopez-Pamies (2016)",
     "stress that relaxes: stiffer in fast motion than at rest; damps most near the frequency 1/relaxation_time"},
}};

constexpr std::array<StrainRateInfo, 3> rates{{
    {StrainRate::secant, "secant", "(E(q) - E(q0))/dt", "comparison with other programs; first order in time only"},
    {StrainRate::reconstructed, "reconstructed", "(E(q) - E0)/dt, E0 from the strains of earlier stages",
     "backward-euler, bdf2, bdf3, dirk22, symplectic-dirk22: keeps their order and has a potential"},
    {StrainRate::exact, "exact", "sym(F^T (F - F0))/dt", "keeps the order of every method; has no potential"},
}};

}  // namespace

std::span<const LawInfo> viscosity_laws() {
  return laws;
}

std::span<const StrainRateInfo> strain_rates() {
  return rates;
}

ViscosityVariant make_viscosity(std::string_view name, std::span<const double> values, StrainRate rate,
                                const Location& where) {
  const LawInfo* row = nullptr;
  for (const auto& law : laws) {
    if (law.name == name) row = &law;
  }
  if (row == nullptr) {
    throw InputError(where, fmt::format("unknown model '{}'; the models are {}", name, names_of(laws)));
  }
  assert(values.size() == row->parameters.size());
  std::vector<Diagnostic> mistakes;
  for (std::size_t n = 0; n < values.size(); ++n) {
    if (const auto text = complaint(row->parameters[n], values[n])) mistakes.push_back({where, *text});
  }
  if (!mistakes.empty()) throw InputError(std::move(mistakes));
  if (name == KelvinVoigt::name) return KelvinVoigt{values[0], values[1], rate};
  return Maxwell{values[0], values[1], values[2]};
}

}  // namespace pliant
