/// Checks that apply to every mesh file, and the report of its defects.
#pragma once

#include "mesh/serial_mesh.hpp"

#include <cstdint>
#include <functional>
#include <string>

namespace pliant {

/// Runs `work`; converts a MeshDefect to an InputError with each of its reasons at the place that names the file.
void telling_the_user(const MeshSource& source, const std::function<void()>& work);

/// Throws MeshDefect if the file does not exist, is empty, or is a pipe or a device; FileError if it may not be read.
void require_readable(const std::string& file);

/// The whole contents of the file. Throws FileError if it cannot be read.
std::string file_contents(const std::string& file);

/// Throws MeshDefect if the name of a group or of data has control characters: names are printed, and separate fields
/// in messages between ranks.
void require_plain_name(const std::string& name);

/// Throws MeshDefect if a size, scale or number of refinements is not valid.
void require_sane(const MeshSource& source);

/// Throws MeshDefect if the source has a size or local sizes, which a file that is a mesh cannot follow.
void require_no_sizes(const MeshSource& source);

/// Throws MeshDefect if ranks would have no cell.
void require_enough_cells(std::int64_t num_cells, int num_ranks);

/// Likewise, for a source without a file, whose cells are those of rods and of rigid bodies.
void require_enough_added_cells(std::int64_t num_cells, int num_ranks);

}  // namespace pliant
