/// Double-logarithmic plots of convergence studies as SVG files, in the style of tools/plot.py.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <petscsys.h>

namespace pliant {

/// Points joined by lines; x and y are equally long. Points that a logarithmic plot cannot show (not finite, or not
/// above zero) are left out.
struct PlotSeries {
  std::string name;
  std::vector<double> x, y;
};

struct LogLogPlot {
  std::string title;
  std::string x_label;  ///< with its unit: "time step [s]"
  std::string y_label;
  std::vector<PlotSeries> series;
  std::vector<double> slopes = {};  ///< orders p; each is drawn as a triangle of slope p below the series nearest to it
};

/// The plot as a complete SVG document; texts may be any UTF-8. Not collective.
std::string svg(const LogLogPlot& plot);

/// Writes the plot on rank 0; a reader sees the old file or the new one. A failure throws FileError on every rank.
/// Collective.
void write_svg(MPI_Comm comm, const std::filesystem::path& file, const LogLogPlot& plot);

}  // namespace pliant
