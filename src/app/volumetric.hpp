/// How the bodies resist a change of volume: `volumetric` of the input.
#pragma once

#include "app/config.hpp"
#include "app/input_tree.hpp"
#include "material/elastic_law.hpp"

#include <petscvec.h>

namespace pliant {

/// Adds what the treatment of the volume cannot be combined with. `root`: of the input.
void check_volumetric(const Config& config, const InputNode& root, Problems& problems);

/// Throws InputError at `where` if the law is incompressible, for bodies without pressures.
void require_compressible(const ElasticLawSpec& law, const Location& where);

/// Throws InputError at a constraint if the bodies do not start undeformed, for bodies with pressures. Collective.
void require_undeformed(const Config& config, Vec q);

}  // namespace pliant
