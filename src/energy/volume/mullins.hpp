/// Softening of a body by the largest strain it has seen (Mullins effect, Ogden & Roxburgh): what it takes from the
/// body's elastic energy and stress (material/mullins.hpp). With W the energy of the law without its volumetric part
/// and Wm(X) the largest W over all accepted states,
///
///     Phi(q) = int h(W; Wm) dX,   P = (eta - 1) dW/dF,   A = (eta - 1) d2W/dF2 + d eta/dW dW/dF (x) dW/dF
///
/// so that together with the elastic term the distortion has the stress eta dW/dF, below Wm as above it, and a stage
/// still minimises a potential. With D(Wm) = h(0; Wm), the body stores h(W; Wm) - D(Wm) in addition to what its law
/// does, and has lost D(Wm): whatever the path, and however the time steps divide it.
#pragma once

#include "energy/stress.hpp"
#include "fem/cells.hpp"
#include "material/law_field.hpp"
#include "material/mullins.hpp"

#include <memory>

namespace pliant {

/// `distortion`: the law without its volumetric part; its packs are the body's quadrature points. `groups` holds the
/// cells of all bodies and must outlive the term. Internal variables: Wm at every quadrature point
/// (energy/volume/point_tensor.hpp), which `complete_step` sets, whatever the method; 0 at rest.
template <int Order>
std::unique_ptr<StressTerm> make_mullins_term(const Mullins& softening, std::shared_ptr<const LawField> distortion,
                                              const CellGroups<Order>& groups, int body, PetscInt num_owned_nodes);

}  // namespace pliant
