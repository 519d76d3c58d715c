/// Strain energy of a nearly incompressible body whose volume is averaged over each cell: mean dilatation.
///
///     U = sum_e int_e psi(Fbar) dX,  Fbar = (theta/J)^(1/3) F,  theta = 1/V_e int_e J dX
///
/// A cell then resists a change of its total volume instead of one at each of its points, which suits quadratic cells:
/// P2 for the displacement, P0 for the volume and the pressure. It remains an energy of the displacement alone.
/// With Psi(F, theta) = psi(Fbar) (material/dilatation.hpp), g = dtheta/dq and p = 1/V_e int_e Psi_theta dX
///
///     dU/dq    = int (Psi_F + p cof F) : dF
///     d2U/dq2  = int dF : (Psi_FF + p d cof F/dF) : dF + h g^T + g h^T + (int Psi_theta,theta) g g^T
///     h        = int Psi_F,theta : dF
///
/// In a body that expands by s (energy/volume/expansion.hpp) each point has its share of the cell's volume, m theta
/// with m = V_e s^3 / int s^3 dX in the place of theta.
///
/// Sources: Nagtegaal, Parks & Rice, Comput. Methods Appl. Mech. Eng. 4 (1974) 153-177; Simo, Taylor & Pister, ibid. 51
/// (1985) 177-208.
#pragma once

#include "energy/volume/elastic.hpp"

namespace pliant {

/// As make_elastic_term, for quadratic cells and any law that is exact under rotation; its energy is a barrier in J at
/// the quadrature points where the law's is.
std::unique_ptr<ElasticTerm> make_mean_dilatation_term(std::shared_ptr<const LawField> law, const CellGroups<2>& groups,
                                                       int body, PetscInt num_owned_nodes, FreeShape shape = {});

}  // namespace pliant
