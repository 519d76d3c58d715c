/// The results of `pliant modes`: a table for the terminal, modes.csv, result.h5 with result.xdmf.
#pragma once

#include "input/config.hpp"
#include "model/model.hpp"
#include "study/mode.hpp"

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace pliant {

/// One line for each mode, below a head, and the sum of the effective masses.
std::vector<std::string> mode_table(std::span<const Mode> modes);

/// Columns: mode, eigenvalue [1/s^2], frequency [Hz], growth_rate [1/s], damping_ratio (nan where there is none) and
/// effective_mass_x, effective_mass_y, effective_mass_z, fractions of the whole mass. Collective.
void write_modes_csv(MPI_Comm comm, const std::filesystem::path& directory, std::span<const Mode> modes);

/// A frame for each mode, whose time is its number and whose label shows its frequency. Fields: displacement, that of
/// the state plus the shape, scaled such that its largest is a tenth of the size of the bodies; mode_shape, the shape
/// [1/sqrt(kg)]. `q`: the state. Collective.
void write_mode_frames(const std::filesystem::path& directory, const Config& config, const Model& model, Vec q,
                       std::span<const Mode> modes);

}  // namespace pliant
