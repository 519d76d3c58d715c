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
/// A law of small strain (linear) has its stress and the small strain in the place of S_e and E. A law without its part
/// of the volume (`volumetric` other than standard) that does not feel a change of volume has the isochoric strain
/// (J^(-2/3) C - I)/2, so that its branches do not resist one either (energy/volume/branch_law.hpp). In a body that
/// expands by s (energy/volume/expansion.hpp) all of this is that of F/s, per volume of the expanded body.
/// Sources: Simo, Comput. Methods Appl. Mech. Eng. 60 (1987), 153-173; Holzapfel, Nonlinear Solid Mechanics (2000),
/// section 6.10.
#pragma once

#include "energy/volume/expansion.hpp"
#include "fem/cells.hpp"
#include "material/law_field.hpp"
#include "material/viscosity.hpp"

#include <memory>
#include <vector>

namespace pliant {

/// The branches of one body. `groups` holds the cells of all bodies and must outlive the term. Internal variables: A at
/// every quadrature point (energy/volume/point_tensor.hpp), branch by branch; 0 at rest.
template <int Order>
std::unique_ptr<EnergyTerm> make_prony_term(std::vector<Prony> branches, std::shared_ptr<const LawField> elastic,
                                            const CellGroups<Order>& groups, int body, PetscInt num_owned_nodes,
                                            std::shared_ptr<const FreeExpansion> expansion = nullptr);

}  // namespace pliant
