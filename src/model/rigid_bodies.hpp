/// Rigid bodies of the input on a mesh: what they add to it, their masses, and what is implied by them.
#pragma once

#include "energy/volume/affine_bodies.hpp"
#include "input/config.hpp"
#include "mesh/mesh.hpp"

#include <string>
#include <vector>

namespace pliant {

/// The input with each entry of `rigid_bodies` among the bodies, after the others, and with the constraint that makes a
/// body rigid where the input has none for it. What a body without a mesh has of `density` makes its tetrahedron as
/// heavy as the body.
Config with_rigid_bodies(Config config);

/// One for each entry of `rigid_bodies`: about as large as the body.
std::vector<AddedTetrahedron> added_tetrahedra(const Config& config);

/// The masses of `rigid_bodies`; `first`: the number of the first among the bodies.
std::vector<AffineBody> masses_of_rigid_bodies(const Config& config, int first);

/// Names of `rigid_bodies`.
std::vector<std::string> names_of_rigid_bodies(const Config& config);

}  // namespace pliant
