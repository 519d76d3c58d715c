/// How the bodies resist a change of volume: `volumetric` of the input.
#pragma once

#include "input/config.hpp"
#include "input/tree.hpp"
#include "material/elastic_law.hpp"

namespace pliant {

/// Adds what the treatment of the volume cannot be combined with. `root`: of the input.
void check_volumetric(const Config& config, const InputNode& root, Diagnostics& diagnostics);

/// Throws InputError at `where` if the law is incompressible, for bodies without pressures.
void require_compressible(const ElasticLawSpec& law, const Location& where);

}  // namespace pliant
