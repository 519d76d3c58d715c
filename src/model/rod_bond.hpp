/// What keeps rods in bodies from turning about their axes.
#pragma once

#include "model/attached_points.hpp"
#include "model/rods.hpp"

#include <span>

namespace pliant {

/// Rods along curves share nodes with bodies, which does not keep them from turning about their axis. The places of
/// their sections that lie inside a body are held in it by springs, which together have the stiffness 2 G l, G the
/// body's shear modulus and l the length of the segment: about that of the material around a rod. These places are all
/// around a round section, and at the ends of the directors of a rectangle, on both sides. Along a free shell alone
/// they lie in the planes of the triangles at the segment. `shear_moduli`: of each body [Pa]. Collective.
void add_bond(const BodiesOnMesh& bodies, std::span<const double> shear_moduli, ModelRods& rods);

}  // namespace pliant
