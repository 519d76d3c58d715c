/// Maps as SVG files: a number over two others, as colours.
#pragma once

#include "io/svg_axes.hpp"

#include <string>
#include <vector>

namespace pliant {

/// Values at points (x, y); the three lists are equally long. Points whose x or y the axes cannot show are left out.
struct ValueMap {
  std::string title;
  std::string x_label, y_label, value_label;  ///< with their units
  std::vector<double> x, y, values;           ///< a value that is not finite is drawn grey
  Scale x_scale = Scale::linear, y_scale = Scale::linear;
};

/// The map as a complete SVG document. Where the points are a full grid (every x with every y, at least two of each,
/// once) it is a heat map: a rectangle around each point, and contours through the values at the ticks of the colour
/// bar, interpolated linearly along the lines of the grid. Otherwise each point is a mark. Not collective.
std::string svg_map(const ValueMap& map);

}  // namespace pliant
