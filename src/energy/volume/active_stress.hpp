/// Active stress of muscle: a tension T(x, t) per reference area along the fibres f, in addition to the body's own
/// stress,
///     U = int T/2 (I4 - 1) dX,  I4 - 1 = 2 f.Ef,  S = T f (x) f
/// Its work is done on the body, as by a load. Source: Ambrosi & Pezzuto, J. Elasticity 107 (2012) 199-212, section 2.
#pragma once

#include "energy/volume/activation.hpp"

#include <memory>

namespace pliant {

/// The term of the cells of `body`; `groups` holds the cells of all bodies and must outlive it. The amounts of
/// `tension` are T [Pa].
template <int Order>
std::unique_ptr<EnergyTerm> make_active_stress_term(std::shared_ptr<const Activation> tension,
                                                    const CellGroups<Order>& groups, int body,
                                                    PetscInt num_owned_nodes);

}  // namespace pliant
