#include "mesh/gmsh_module.hpp"

#include <dlfcn.h>

namespace pliant {
namespace {

/// `pliant_gmsh`, which the library defines (mesh/gmsh/meshing.hpp). It is found along the program's run path.
const GmshModule* load() {
  void* const library = dlopen("libpliant_gmsh.so", RTLD_NOW | RTLD_LOCAL);
  void* const module = library == nullptr ? nullptr : dlsym(library, "pliant_gmsh");
  if (module != nullptr) return static_cast<const GmshModule*>(module);
  throw MeshDefect(std::string("cannot load gmsh, which meshes geometry: ") + dlerror() +
                   "; check that Pliant is installed completely");
}

}  // namespace

const GmshModule& gmsh_module() {
  static const GmshModule* const module = load();
  return *module;
}

}  // namespace pliant
