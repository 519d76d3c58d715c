/// A fit as one page of HTML that needs no other file, and its plots as SVG files.
#pragma once

#include "study/fit.hpp"

#include <filesystem>

namespace pliant {

/// Writes report.html, and for each test two plots: the measurements with the fitted curve (1_uniaxial.svg) and the
/// residuals (1_uniaxial_residuals.svg). Not collective.
void write_report(const FittedMaterial& fit, const std::filesystem::path& directory);

}  // namespace pliant
