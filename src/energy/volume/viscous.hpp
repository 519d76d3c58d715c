/// Viscosity in the strain of a body: Kelvin-Voigt, Maxwell and stiffness-proportional damping (material/viscosity.hpp)
/// as terms of a stage.
///
/// All are a dashpot of viscosity eta behind a spring of stiffness eta / tau; except for Maxwell's, the spring is
/// rigid,
/// tau = 0. The dashpot's strain G obeys tau Gdot = E - G, so at the end of a stage of length dt that starts from G0
///
///     G - G0 = dt / (tau + dt) (E - G0)
///     Phi(q) = int 1/2 (E - G0) : eta / (tau + dt) : (E - G0) dX
///     dissipation = int Gdot : eta : Gdot dX,   Gdot = (E - G0) / (tau + dt)
///
/// (docs/theory.md, "Strain rates and their orders"). The three forms of the rate of a dashpot alone differ in the
/// reference strain G0: `secant` has E(q0), `reconstructed` takes G = E as one more variable of the method, `exact`
/// uses sym(F^T (F - F0)) instead of E - G0, and has no potential.
///
/// A body that expands by s (energy/volume/expansion.hpp) has E_e = (E - (s^2 - 1)/2 I) / s^2 in the place of E, and
/// the volume s^3 dX: expansion alone meets no resistance. With k = sdot/s the rate of a dashpot alone is
///
///     Edot_e = (Edot - k C) / s^2,   C = 2 E + I
#pragma once

#include "energy/volume/expansion.hpp"
#include "fem/cells.hpp"
#include "material/law_field.hpp"
#include "material/viscosity.hpp"
#include "time/method.hpp"

#include <memory>
#include <string_view>
#include <variant>

namespace pliant {

/// A law in the rate of E, and how a stage forms that.
template <class Law>
struct WithStrainRate {
  static constexpr std::string_view name = Law::name;

  Law law;
  StrainRate rate;
};
template <class Law>
WithStrainRate(Law, StrainRate) -> WithStrainRate<Law>;  // for clang before 17

/// The laws in E.
using ViscosityVariant = std::variant<WithStrainRate<KelvinVoigt>, Maxwell, WithStrainRate<StiffnessProportional>>;

/// A term of the cells of `body`; `groups` holds the cells of all bodies and must outlive it. A body of several Maxwell
/// branches has several terms. Internal variables (`reconstructed`, `maxwell`): G at every quadrature point as xx yy zz
/// xy yz xz, cell by cell in the order of the groups, ghost cells included. They start at 0, the undeformed body at
/// rest, and `complete_step` sets the reconstructed strains of any other configuration. `elastic`, the body's isotropic
/// elastic law, gives what is proportional to its stiffness; its packs are the body's quadrature points.
template <int Order>
std::unique_ptr<EnergyTerm> make_viscous_term(const ViscosityVariant& law, const LawField& elastic,
                                              const CellGroups<Order>& groups, int body, PetscInt num_owned_nodes,
                                              std::shared_ptr<const FreeExpansion> expansion = nullptr);

/// The form of the strain rate that keeps the method's order: a form with a potential if there is one (`secant`, which
/// needs no memory, before `reconstructed`), else `exact`.
StrainRate strain_rate_for(const Method& method);

}  // namespace pliant
