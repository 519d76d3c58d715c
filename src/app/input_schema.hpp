/// The table of the input's keys, and what follows from it.
#pragma once

#include "app/schema.hpp"

#include <array>
#include <string_view>

namespace pliant {

/// What `time: {method: ...}` takes; the last two are no integrators but sequences of equilibria.
inline constexpr std::string_view quasistatic_method = "quasistatic";
inline constexpr std::string_view static_method = "static";
inline constexpr std::array<std::string_view, 4> time_methods{"backward-euler", "bdf2", quasistatic_method,
                                                              static_method};

/// Fields that results may hold.
inline constexpr std::array<std::string_view, 7> output_fields{
    "displacement", "velocity", "acceleration", "cauchy_stress", "von_mises_stress", "volume_ratio", "energy_density"};

/// The whole table; sections hold their keys as children.
const std::vector<KeyInfo>& input_keys();

/// Reads every key that is there and puts the table's defaults for the others.
Config read_config(const InputNode& root, Problems& problems);

/// The tree that read_config reads as this configuration.
InputNode write_config(const Config& config);

/// JSON schema of the whole input.
Json input_schema();

}  // namespace pliant
