/// What a result file (io/result_writer.hpp) says of itself.
#pragma once

#include <filesystem>
#include <string>

namespace pliant {

/// Mesh, frames and fields of a result, for people; FileError where the file is none. Not collective.
std::string describe_result(const std::filesystem::path& file);

}  // namespace pliant
