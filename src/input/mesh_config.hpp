/// The section `mesh` of the input.
#pragma once

#include "base/error.hpp"
#include "input/located.hpp"

#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// A local element size at a physical group, one of the three.
struct LocalSizeConfig {
  std::string surface, curve, point;  ///< name or number
  double size = 0.0;                  ///< [m]
  double distance = 0.0;              ///< [m]
  Location where;
};

struct MeshConfig {
  Located<std::string> file;   ///< resolved against the input file's directory
  std::optional<double> size;  ///< [m]
  std::vector<LocalSizeConfig> sizes;
  double scale = 1.0;
  int refine = 0;
  bool allow_commands = false;
  double time_limit = 3600.0;  ///< [s]
};

}  // namespace pliant
