/// Combinations in an input that are wrong, where only the mesh reveals it (for others see input/checks).
#pragma once

#include "energy/constraint/constraint_map.hpp"
#include "input/config.hpp"
#include "material/elastic_law.hpp"

#include <petscvec.h>

namespace pliant {

/// Throws InputError at `where` if the law is incompressible, for bodies without pressures.
void require_compressible(const ElasticLawSpec& law, const Location& where);

/// Throws InputError at a constraint if bodies with pressures do not start undeformed. Collective.
void require_undeformed(const Config& config, Vec q);

}  // namespace pliant
