/// Meshes of geometry, kept on disk from run to run.
#pragma once

#include "mesh/serial_mesh.hpp"

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace pliant {

/// Everything that a mesh made by gmsh depends on: the contents of `files`, the options of the source, and the versions
/// of Pliant and of gmsh. Throws FileError if a file cannot be read.
std::string recipe_of(const MeshSource& source, const std::vector<std::filesystem::path>& files);

/// The mesh of a recipe: the one kept in an earlier run, with a notice, or else that of `make`, which is then kept.
///
/// Meshes are in pliant/meshes below $XDG_CACHE_HOME, or else ~/.cache; the least recently used go when they take more
/// than 1 GB. What cannot be read or written there is made anew each time, without a word: nothing but time depends on
/// it. Several runs may use the directory at once. Not collective.
SerialMesh kept_or_made(const std::string& recipe, const std::function<SerialMesh()>& make);

}  // namespace pliant
