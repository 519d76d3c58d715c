/// What an input wants written, as typed values in SI units.
#pragma once

#include "input/located.hpp"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// A number taken from a field at every step: a column of the history.
struct FieldColumnConfig {
  /// `norm`: the root of the integral of the square, over all components.
  enum class Take { max, min, mean, integral, norm };
  std::string name;
  Located<std::string> of;  ///< a field, or a component of one (input/output_fields.hpp)
  /// Name of a volume or surface, of a free shell, or of a shell or rod where the field is of those; empty: all bodies,
  /// shells or rods.
  std::optional<Located<std::string>> in;
  std::optional<Take> take;
  std::optional<Located<std::string>> at;  ///< name of a probe, instead of `in` and `take`: the value there
  Location where;
};

struct OutputConfig {
  std::string directory;        ///< resolved against the working directory; default out/<input's stem>
  std::optional<double> every;  ///< [s]; default: the step
  Location every_where;         ///< of `every` in the input, where it is given
  std::vector<std::string> fields;
  bool is_nodal = false;  ///< fields of cells are smoothed to values at nodes
  std::vector<FieldColumnConfig> history;
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
