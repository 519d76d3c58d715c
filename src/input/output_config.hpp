/// What an input wants written, as typed values in SI units.
#pragma once

#include "base/error.hpp"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

struct OutputConfig {
  std::string directory;        ///< resolved against the working directory; default out/<input's stem>
  std::optional<double> every;  ///< [s]; default: the step
  Location every_where;         ///< of `every` in the input, where it is given
  std::vector<std::string> fields;
};

/// When checkpoints are written, in addition to those of interrupted and failed runs.
struct CheckpointConfig {
  std::optional<int> every;       ///< steps
  std::optional<double> minutes;  ///< of the clock
};

struct ProbeConfig {
  std::string name;
  std::array<double, 3> point{};  ///< reference position [m]
  Location where;
};

}  // namespace pliant
