/// Calls libraries that may crash or exit.
#pragma once

#include "base/child_process.hpp"
#include "mesh/serial_mesh.hpp"

#include <functional>

namespace pliant {

/// The library that may crash: gmsh, or HDF5 in a mesh of Pliant or in a MED file.
enum class Suspect { gmsh, hdf5, med };

/// The rights of the child process, and its time limit.
struct Isolation {
  Suspect suspect = Suspect::gmsh;
  ChildLimits limits = {};
};

/// The rights and the time limit of gmsh when it reads the file.
Isolation gmsh_isolation(const MeshSource& source);

/// Runs `work` in a child process of this rank and returns its result. gmsh and its CAD kernel crash on some damaged
/// geometry, a script's `Exit` ends the process, and HDF5 crashes on some damaged files: here that is a MeshDefect, and
/// all their memory is returned. `work` must meet the conditions of in_child(), but may throw. Throws the MeshDefect of
/// `work`; a MeshDefect if the child dies; std::runtime_error for any other failure. Not collective.
SerialMesh isolated(const Isolation& isolation, const std::function<SerialMesh()>& work);

}  // namespace pliant
