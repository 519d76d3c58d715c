/// The table of the input's keys, and what follows from it.
#pragma once

#include "input/schema.hpp"
#include "input/sections/time.hpp"

#include <array>
#include <string_view>

namespace pliant {

/// Fields that results may hold.
inline constexpr std::array<std::string_view, 16> output_fields{"displacement",
                                                                "velocity",
                                                                "acceleration",
                                                                "cauchy_stress",
                                                                "elastic_cauchy_stress",
                                                                "viscous_cauchy_stress",
                                                                "active_cauchy_stress",
                                                                "von_mises_stress",
                                                                "volume_ratio",
                                                                "energy_density",
                                                                "elastic_energy_density",
                                                                "viscous_energy_density",
                                                                "softening",
                                                                "contact_pressure",
                                                                "contact_gap",
                                                                "contact_slip"};

/// The whole table; sections hold their keys as children.
const std::vector<KeyInfo>& input_keys();

/// Reads every key that is there and puts the table's defaults for the others.
Config read_config(const InputNode& root, Diagnostics& diagnostics);

/// The tree that read_config reads as this configuration.
InputNode write_config(const Config& config);

/// JSON schema of the whole input.
JsonSchema input_schema();

}  // namespace pliant
