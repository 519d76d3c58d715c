/// Meshes from libraries that may crash or exit.
#pragma once

#include "base/child_process.hpp"
#include "mesh/serial_mesh.hpp"

#include <functional>

namespace pliant {

/// The library that may not survive the work.
enum class Suspect { gmsh, hdf5 };

/// What the child process may do, and for how long.
struct Isolation {
  Suspect suspect = Suspect::gmsh;
  ChildLimits limits = {};
};

/// What gmsh may do with the file.
Isolation gmsh_isolation(const MeshSource& source);

/// Runs `work` in a child process of this rank and gives its result. gmsh and its CAD kernel crash on some damaged
/// geometry, and a script's `Exit` ends the process, HDF5 crashes over some damaged files: here that is a MeshDefect,
/// and all memory they held is returned. `work` is as in_child() needs it, but may throw. Throws the MeshDefect
/// of `work`; a MeshDefect if the child dies; std::runtime_error for any other failure. Not collective.
SerialMesh isolated(const Isolation& isolation, const std::function<SerialMesh()>& work);

}  // namespace pliant
