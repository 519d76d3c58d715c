#include "material/viscosity_registry.hpp"

#include "base/limits.hpp"

#include <array>

namespace pliant {
namespace {

constexpr std::array kelvin_voigt{
    ParameterInfo{"shear", "Pa*s", 0.0, infinity, "viscosity in shear", LowerBound::included},
    ParameterInfo{"bulk", "Pa*s", 0.0, infinity, "viscosity against volume change", LowerBound::included, 1.0, 0.0},
};

constexpr std::array maxwell{
    ParameterInfo{"shear_modulus", "Pa", 0.0, infinity,
                  "shear modulus of the branch's spring, effective in fast motion", LowerBound::included},
    ParameterInfo{"bulk_modulus", "Pa", 0.0, infinity, "bulk modulus of the branch's spring, effective in fast motion",
                  LowerBound::included, 1.0, 0.0},
    ParameterInfo{"relaxation_time", "s", 0.0, infinity, "time in which the branch's stress decays to 1/e"},
};

constexpr std::array maxwell_ratios{
    ParameterInfo{"shear_ratio", "1", 0.0, infinity,
                  "`shear_modulus` as a fraction of the elastic law's shear modulus at rest", LowerBound::included},
    ParameterInfo{"bulk_ratio", "1", 0.0, infinity,
                  "`bulk_modulus` as a fraction of the elastic law's bulk modulus at rest", LowerBound::included, 1.0,
                  0.0},
    maxwell[2],
};

constexpr std::array prony{
    ParameterInfo{"ratio", "1", 0.0, infinity,
                  "g: stress of the branch in fast motion, as a fraction of the elastic stress; not normalised",
                  LowerBound::included},
    ParameterInfo{"relaxation_time", "s", 0.0, infinity, "time in which the branch's stress decays to 1/e"},
};

constexpr std::array stiffness_proportional{
    ParameterInfo{"time", "s", 0.0, infinity,
                  "beta: the damping ratio of a mode with angular frequency w is beta w / 2", LowerBound::included},
};

constexpr std::array mass_proportional{
    ParameterInfo{
        "decay_rate", "1/s", 0.0, infinity,
        "alpha: a mode of the angular frequency w is damped by alpha / (2 w) of critical, and free motion falls "
        "to 1/e in the time 1/alpha",
        LowerBound::included},
};

constexpr std::array<LawInfo, 5> laws{{
    {KelvinVoigt::name, "R = shear dev(Edot):dev(Edot) + bulk/2 (tr Edot)^2, E = (F^T F - I)/2", kelvin_voigt,
     "Landau & Lifshitz, Theory of Elasticity (1986), section 34, with E for the small strain",
     "damping that grows with frequency: the damping ratio of a mode w is (viscosity/stiffness) w / 2; add some if an "
     "accurate time method shows vibrations that the real body does not have"},
    {Maxwell::name,
     "psi = shear_modulus dev(E-G):dev(E-G) + bulk_modulus/2 (tr(E-G))^2, Gdot = (E - G)/relaxation_time", maxwell,
     "Holzapfel, Nonlinear Solid Mechanics (2000), section 6.10; Kumar & Lopez-Pamies (2016)",
     "stress that relaxes: stiffer in fast motion than at rest; damps most near the frequency 1/relaxation_time; one "
     "entry per branch. `shear_ratio` and `bulk_ratio` give its moduli relative to the elastic law's at rest"},
    {Prony::name, "Hdot + H/relaxation_time = ratio d/dt S_e, S_e the elastic second Piola-Kirchhoff stress", prony,
     "Simo, Comput. Methods Appl. Mech. Eng. 60 (1987); Holzapfel, Nonlinear Solid Mechanics (2000), section 6.10",
     "stress that relaxes by the same fraction at any strain, from a table of a Prony series; one entry per branch"},
    {StiffnessProportional::name, "R = time/2 Edot:C0:Edot, C0 the elastic tangent at rest", stiffness_proportional,
     "Rayleigh, The Theory of Sound (1894), section 81; Bathe, Finite Element Procedures (2014), section 9.3.3",
     "kelvin-voigt with one constant: damping that grows with frequency, for shear and volume alike"},
    {MassProportional::name, "R = decay_rate/2 rho v.v", mass_proportional,
     "Rayleigh, The Theory of Sound (1894), section 81; Bathe, Finite Element Procedures (2014), section 9.3.3",
     "drag of a surrounding medium, or settling to a state of rest; damps low frequencies most, and rigid motion too"},
}};

template <class Law, double Law::*member>
double& value(ViscosityLaw& law) {
  return std::get<Law>(law).*member;
}

/// The values of these members, in order.
template <class Law, double Law::*... members>
constexpr std::array<ViscosityMember, sizeof...(members)> values{value<Law, members>...};

template <class Law, double Law::*... members>
constexpr ViscosityForm form(const std::array<ParameterInfo, sizeof...(members)>& parameters) {
  return {Law{}, parameters, values<Law, members...>};
}

constexpr std::array forms{
    form<KelvinVoigt, &KelvinVoigt::shear, &KelvinVoigt::bulk>(kelvin_voigt),
    form<StiffnessProportional, &StiffnessProportional::time>(stiffness_proportional),
    form<MassProportional, &MassProportional::decay_rate>(mass_proportional),
    form<Maxwell, &Maxwell::shear_modulus, &Maxwell::bulk_modulus, &Maxwell::relaxation_time>(maxwell),
    form<MaxwellRatios, &MaxwellRatios::shear_ratio, &MaxwellRatios::bulk_ratio, &MaxwellRatios::relaxation_time>(
        maxwell_ratios),
    form<Prony, &Prony::ratio, &Prony::relaxation_time>(prony),
};
static_assert(forms.size() == std::variant_size_v<ViscosityLaw>);

constexpr std::array<StrainRateInfo, 3> rates{{
    {StrainRate::secant, "secant", "(E(q) - E(q0))/dt", "comparison with other programs; first order in time only"},
    {StrainRate::reconstructed, "reconstructed", "(E(q) - E0)/dt, E0 from the strains of earlier stages",
     "backward-euler, bdf2, bdf3, dirk22, symplectic-dirk22: keeps their order and has a potential"},
    {StrainRate::exact, "exact", "sym(F^T (F - F0))/dt", "keeps the order of every method; has no potential"},
}};

}  // namespace

std::string_view name_of(const ViscosityLaw& law) {
  return std::visit([](const auto& one) { return one.name; }, law);
}

bool has_strain_rate(const ViscosityLaw& law) {
  return std::visit(
      []<class Law>(const Law&) {
        return std::is_same_v<Law, KelvinVoigt> || std::is_same_v<Law, StiffnessProportional>;
      },
      law);
}

std::span<const ViscosityForm> viscosity_forms() {
  return forms;
}

std::span<const LawInfo> viscosity_laws() {
  return laws;
}

std::span<const StrainRateInfo> strain_rates() {
  return rates;
}

}  // namespace pliant
