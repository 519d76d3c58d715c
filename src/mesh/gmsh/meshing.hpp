/// Meshes of geometry by gmsh: what the library of this folder gives to those that load it.
#pragma once

#include "mesh/gmsh_module.hpp"

/// Where gmsh_module() finds it.
extern "C" const pliant::GmshModule pliant_gmsh;
