/// How the bodies resist a change of volume: `volumetric` of the input.
#pragma once

#include "input/config.hpp"
#include "input/tree.hpp"
#include "material/elastic_law.hpp"

#include <string_view>

namespace pliant {

/// Adds what the treatment of the volume cannot be combined with. `root`: of the input.
void check_volumetric(const Config& config, const InputNode& root, Diagnostics& diagnostics);

/// Is the law's resistance to a change of volume infinite?
bool is_incompressible(const ElasticLawSpec& law);

inline constexpr std::string_view incompressible_without_pressures =
    "the body is incompressible, for which displacements alone have no solution; add 'volumetric: mixed' or lower "
    "'poissons_ratio'";

}  // namespace pliant
