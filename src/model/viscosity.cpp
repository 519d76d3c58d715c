#include "model/viscosity.hpp"

#include "energy/volume/mass_damping.hpp"
#include "energy/volume/prony.hpp"
#include "energy/volume/viscous.hpp"
#include "input/analysis.hpp"
#include "model/shells.hpp"

#include <algorithm>
#include <optional>

namespace pliant {
namespace {

/// The exact form, which needs no history, where the method is not one of Pliant's.
StrainRate automatic_rate(const Method* method) {
  return method == nullptr ? StrainRate::exact : strain_rate_for(*method);
}

/// The law of a term in the strain of each point; nothing for Prony series and for damping by mass, which are other
/// terms.
struct LawInStrain {
  using Result = std::optional<ViscosityVariant>;
  StrainRate rate;
  bool resists_dilatation;

  Result operator()(const KelvinVoigt& law) const { return WithStrainRate<KelvinVoigt>{law, rate}; }
  Result operator()(const StiffnessProportional& law) const {
    return WithStrainRate<StiffnessProportional>{{law.time, resists_dilatation}, rate};
  }
  Result operator()(const Maxwell& law) const { return law; }
  Result operator()(const MaxwellRatios& law) const {
    return Maxwell{law.shear_ratio, law.bulk_ratio, law.relaxation_time, Moduli::relative};
  }
  Result operator()(const Prony&) const { return std::nullopt; }
  Result operator()(const MassProportional&) const { return std::nullopt; }
};

/// alpha rho of each body [kg/(s m^3)]; 0 of rods and of rigid bodies by their mass, which `config` may lack.
std::vector<double> damping_densities(const Config& config, std::size_t num_bodies) {
  std::vector<double> densities(num_bodies, 0.0);
  for (std::size_t b = 0; b < config.bodies.size(); ++b) {
    const BodyConfig& body = config.bodies[b];
    for (const auto& mechanism : body.viscosity) {
      const auto* law = std::get_if<MassProportional>(&mechanism.law);
      if (law != nullptr) densities[b] += law->decay_rate * body.density.value_or(0.0);
    }
  }
  return densities;
}

template <int Order>
std::vector<std::unique_ptr<EnergyTerm>> make_terms(const Config& config, const BodyParts& on,
                                                    const CellGroups<Order>& groups) {
  const StrainRate automatic = automatic_rate(integrator_of(config));
  const bool resists_dilatation = config.volumetric == VolumetricTreatment::standard;
  std::vector<std::unique_ptr<EnergyTerm>> terms;
  for (std::size_t b = 0; b < config.bodies.size(); ++b) {
    std::vector<Prony> branches;
    for (const auto& mechanism : config.bodies[b].viscosity) {
      if (const auto* branch = std::get_if<Prony>(&mechanism.law)) branches.push_back(*branch);
      const auto law = std::visit(LawInStrain{mechanism.rate.value_or(automatic), resists_dilatation}, mechanism.law);
      if (!law) continue;
      terms.push_back(make_viscous_term<Order>(*law, *on.elastic[b], groups, static_cast<int>(b),
                                               on.layout.num_owned_nodes, on.expansions[b]));
    }
    if (branches.empty()) continue;
    terms.push_back(make_prony_term<Order>(std::move(branches), on.elastic[b], groups, static_cast<int>(b),
                                           on.layout.num_owned_nodes, on.expansions[b]));
  }
  const auto damping = damping_densities(config, on.elastic.size());
  if (std::ranges::any_of(damping, [](double density) { return density > 0.0; })) {
    const Mass mass = config.mass == MassKind::lumped ? Mass::lumped : Mass::consistent;
    terms.push_back(std::make_unique<MassDamping>(make_mass_matrix<Order>(on.layout, on.pattern, groups, damping, mass),
                                                  make_cell_mass_products<Order>(on.layout, groups, damping, mass)));
  }
  return terms;
}

}  // namespace

bool has_viscosity(const Config& config) {
  return std::ranges::any_of(config.bodies, [](const BodyConfig& body) { return !body.viscosity.empty(); }) ||
         std::ranges::any_of(config.shells, [](const ShellConfig& shell) { return viscosity_of(shell).is_any(); });
}

std::vector<std::unique_ptr<EnergyTerm>> make_viscous_terms(const Config& config, const BodyParts& on) {
  if (analysis_of(config) == Analysis::static_equilibrium) return {};
  return std::visit([&](const auto& groups) { return make_terms(config, on, groups); }, on.cells);
}

}  // namespace pliant
