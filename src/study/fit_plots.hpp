/// The plots of a fit.
#pragma once

#include "io/svg_plot.hpp"
#include "study/fit.hpp"

#include <string>
#include <vector>

namespace pliant {

struct NamedPlot {
  std::string name;  ///< of its file, without the extension
  Plot plot;
};

/// For each test the measurements with the fitted curve, then its residuals. Elastic tests are also shown together, if
/// there are several.
std::vector<NamedPlot> plots_of(const FittedMaterial& fit);

}  // namespace pliant
