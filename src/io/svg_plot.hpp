/// Plots as SVG files, in the style of `pliant plot`: double-logarithmic ones of convergence studies, linear ones of
/// laws, measurements with the curves that were fitted to them.
#pragma once

#include "io/svg_axes.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <petscsys.h>

namespace pliant {

enum class SeriesStyle {
  by_scale,  ///< a line, with marks if the vertical axis is logarithmic
  line,
  marks,
  line_with_marks,
};

/// Points joined by lines; x and y are equally long. Points that the plot cannot show (not finite, or not above zero
/// where it is logarithmic) are left out.
struct PlotSeries {
  std::string name;
  std::vector<double> x, y;
  SeriesStyle style = SeriesStyle::by_scale;
  std::optional<std::size_t> look = {};  ///< number of its colour and mark; by default the number of the series
};

struct Plot {
  std::string title;
  std::string x_label;  ///< with its unit: "time step [s]"
  std::string y_label;
  std::vector<PlotSeries> series;
  std::vector<double> slopes = {};  ///< orders p; each is drawn as a triangle of slope p below the series nearest to it
  Scale scale = Scale::logarithmic;   ///< of both axes
  std::optional<Scale> x_scale = {};  ///< of the horizontal axis, if it has another
};

/// The plot as a complete SVG document; texts may be any UTF-8. Not collective.
std::string svg(const Plot& plot);

/// Writes the plot on rank 0; a reader sees the old file or the new one. A failure throws FileError on every rank.
/// Collective.
void write_svg(MPI_Comm comm, const std::filesystem::path& file, const Plot& plot);

}  // namespace pliant
