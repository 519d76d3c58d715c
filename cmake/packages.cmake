# Every library Pliant stands on, as imported targets.
find_package(PkgConfig REQUIRED)
find_package(MPI REQUIRED COMPONENTS C)
pkg_check_modules(PETSC REQUIRED IMPORTED_TARGET PETSc>=3.18)
pkg_check_modules(HDF5 REQUIRED IMPORTED_TARGET hdf5-openmpi)
pkg_check_modules(MUPARSER REQUIRED IMPORTED_TARGET muparser)
pkg_check_modules(UDUNITS REQUIRED IMPORTED_TARGET udunits)
find_package(yaml-cpp REQUIRED)
find_package(fmt REQUIRED)
find_package(CLI11 REQUIRED)
find_package(nlohmann_json REQUIRED)
find_library(GMSH_LIBRARY gmsh REQUIRED)
find_library(METIS_LIBRARY metis REQUIRED)
find_library(SMUMPS_LIBRARY smumps REQUIRED)

# glibc's vector mathematics (base/vector_math.hpp); it exists on x86-64 only.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  find_library(PLIANT_VECTOR_MATH mvec REQUIRED)
endif()
