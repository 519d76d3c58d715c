/// What is asked of every mesh file, and how its defects are told.
#pragma once

#include "mesh/serial_mesh.hpp"

#include <cstdint>
#include <functional>

namespace pliant {

/// Runs `work`; a MeshDefect becomes the InputError that tells each of its reasons at the place that names the file.
void telling_the_user(const MeshSource& source, const std::function<void()>& work);

/// Throws MeshDefect if there is no such file, nothing in it, or no end to it (a pipe, a device); FileError if it may
/// not be read.
void require_readable(const std::string& file);

/// Throws MeshDefect if the name of a group or of data has control characters: names are printed, and messages between
/// ranks end at them.
void require_plain_name(const std::string& name);

/// Throws MeshDefect if a size, scale or number of refinements makes no sense.
void require_sane(const MeshSource& source);

/// Throws MeshDefect if ranks would stay without a cell.
void require_enough_cells(std::int64_t num_cells, int num_ranks);

}  // namespace pliant
