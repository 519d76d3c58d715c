/// Triangles with values as a file of VTK (.vtu, XML in plain text), for ParaView and other tools.
#pragma once

#include "base/vector3.hpp"

#include <array>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace pliant {

/// A number of each triangle.
struct FacetField {
  std::string name;
  std::vector<double> values;
  bool is_whole = false;  ///< whole numbers
};

/// Writes the file as a whole or not at all; FileError if that fails. Corners that coincide are one point. Not
/// collective.
void write_facets(const std::filesystem::path& file, std::span<const std::array<Vector3<double>, 3>> corners,
                  std::span<const FacetField> fields);

}  // namespace pliant
