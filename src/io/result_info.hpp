/// The description of a result file (io/result_writer.hpp).
#pragma once

#include <filesystem>
#include <string>

namespace pliant {

/// Mesh, frames and fields of a result as text; FileError if the file is not a result. Not collective.
std::string describe_result(const std::filesystem::path& file);

}  // namespace pliant
