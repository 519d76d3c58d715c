/// How a thin layer lies on facets.
#pragma once

#include <array>
#include <optional>

namespace pliant {

struct LayerShape {
  double thickness = 0.0;                          ///< before it was stretched onto them [m]
  std::array<double, 2> stretch{1.0, 1.0};         ///< by how much it was, along its axes
  std::optional<std::array<double, 3>> direction;  ///< the first axis is its part in the facet; none: any axes

  /// Volume of the layer per area of the facets at rest [m].
  double volume_per_area() const { return thickness / (stretch[0] * stretch[1]); }
};

}  // namespace pliant
