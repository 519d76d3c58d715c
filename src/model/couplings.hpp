/// The surfaces of the input whose mean motion rigid bodies follow (`coupled`), on a mesh.
#pragma once

#include "energy/rigid/distributing_coupling.hpp"
#include "model/attached_points.hpp"
#include "model/selections.hpp"

#include <memory>
#include <span>
#include <vector>

namespace pliant {

struct ModelCoupling {
  std::unique_ptr<DistributingCoupling> term;
  Diagnostic note;  ///< what is coupled, and how stiff
};

/// One for each coupled surface. Without a stiffness in the input it is 1000 E sqrt(A): a surface of the area A gives
/// way by about 1 / (E sqrt(A)) where a force is spread over it. E is estimated as three times the shear modulus of its
/// body at rest. `shear_moduli`: of each body [Pa]; `rigid_parts`: per local node, 0 if it belongs to none. Throws
/// InputError at surfaces that are not there, that belong to a rigid part, or that lie on a line. Collective.
std::vector<ModelCoupling> make_couplings(const BodiesOnMesh& bodies, std::span<const double> shear_moduli,
                                          const std::vector<int>& rigid_parts, Selections& selections);

}  // namespace pliant
