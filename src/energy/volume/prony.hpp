/// Finite linear viscoelasticity with the stress of the elastic law, the Prony series of most programs:
///
///     S = S_e(E) + sum_i H_i,   Hdot_i + H_i / tau_i = g_i d/dt S_e
///
/// with S_e the whole elastic second Piola-Kirchhoff stress. With A_i, the elastic stress that the branch has
/// forgotten,
///
///     tau_i Adot_i = S_e - A_i,   H_i = g_i (S_e - A_i)
///
/// At the end of a stage of length dt that starts from A_i0, A_i - A_i0 = dt / (tau_i + dt) (S_e - A_i0), and
///
///     Phi(q) = int sum_i c_i (psi_e(E) - A_i0 : E) dX,   c_i = g_i tau_i / (tau_i + dt)
///     P = sum_i c_i (P_e - F A_i0),   dP = sum_i c_i (dP_e - dF A_i0)
///
/// so that a stage still minimises a potential and all branches together cost one evaluation of the law. What a branch
/// stores is the distance of E from E_i, the strain at which the law has the stress A_i, as psi_e measures it, and what
/// it dissipates is never negative where S_e is monotone in E (psi_e convex in E):
///
///     Y_i = g_i (psi_e(E) - psi_e(E_i) - A_i : (E - E_i)),   S_e(E_i) = A_i
///     D_i = g_i (S_e - A_i) : (E - E_i) / tau_i
///     H_i : Edot = d/dt Y_i + D_i
///
/// A law of small strain (linear) has its stress and the small strain in the place of S_e and E.
/// Sources: Simo, Comput. Methods Appl. Mech. Eng. 60 (1987), 153-173; Holzapfel, Nonlinear Solid Mechanics (2000),
/// section 6.10. They take the isochoric part of S_e; its energy is not convex in E, and Y and D would not exist.
#pragma once

#include "energy/term.hpp"
#include "fem/cells.hpp"
#include "material/law_field.hpp"
#include "material/viscosity.hpp"

#include <memory>
#include <vector>

namespace pliant {

/// The energy that a branch stores per reference volume, and the strain from which it is measured.
struct BranchState {
  Pack energy;               ///< psi_e(E) - psi_e(E_i) - A_i : (E - E_i) [J/m^3]
  Tensor3<Pack> elongation;  ///< E - E_i
};

/// The state of a branch that has relaxed by the stress A [Pa] at the gradient H, by Newton's method starting from E;
/// `n` as in LawField. If psi_e is not convex and there is no such strain, the result of the last iteration.
BranchState branch_state(const LawField& elastic, std::size_t n, const Tensor3<Pack>& H, const Tensor3<Pack>& A);

/// The branches of one body. `groups` holds the cells of all bodies and must outlive the term. Internal variables: A at
/// every
/// quadrature point (energy/volume/point_tensor.hpp), branch by branch; 0 at rest.
template <int Order>
std::unique_ptr<EnergyTerm> make_prony_term(std::vector<Prony> branches, std::shared_ptr<const LawField> elastic,
                                            const CellGroups<Order>& groups, int body, PetscInt num_owned_nodes);

}  // namespace pliant
