/// What cannot be combined with `volumetric`, the resistance to a change of volume.
#pragma once

#include "input/config.hpp"
#include "input/tree.hpp"
#include "material/elastic_law.hpp"

#include <optional>
#include <string>
#include <string_view>

namespace pliant {

/// Reports what cannot be combined with the treatment of the volume. `root`: of the input.
void check_volumetric(const Config& config, const InputNode& root, Diagnostics& diagnostics);

/// Is the law's resistance to a change of volume infinite?
bool is_incompressible(const ElasticLawSpec& law);

/// Is a body incompressible everywhere?
bool has_incompressible_body(const Config& config);

/// The error of a method that cannot be used with incompressible bodies; nullopt if it can.
std::optional<std::string> method_error_of_incompressible_bodies(const Config& config);

/// The error of a law with the volumetric part `kappa` [Pa] <= 0 in a body with pressures.
std::string lacks_volumetric_stiffness(std::string_view model, double kappa);

inline constexpr std::string_view incompressible_without_pressures =
    "displacements alone cannot represent an incompressible body; add 'volumetric: mixed', or lower 'poissons_ratio' "
    "('incompressible: true' stands for 1/2)";

}  // namespace pliant
