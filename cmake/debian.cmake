# `cpack` makes two packages for Debian: pliant, the program, and libpliant-dev, what other programs are built with.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "the Pliant authors <pliant@localhost>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL program development)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)

set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME pliant)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # or it would be the first line of both descriptions, before their own
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION "${PROJECT_DESCRIPTION}
Simulates hyperelastic and viscoelastic bodies, meshed by gmsh, under large
deformation, in motion or at rest, on any number of MPI ranks.")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)  # dpkg-shlibdeps finds what the program and its module link
# What `import pliant` imports is needed, so that it does not fail; `pliant render` and `pliant plot` say what they need besides.
set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS "openmpi-bin, python3-h5py, python3-numpy, python3-yaml")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS libopenblas0-pthread)  # the slow reference BLAS satisfies PETSc too
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "gmsh, paraview, python3-mpi4py, python3-vtk9, python3-matplotlib, python3-pil, ffmpeg, xvfb")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libpliant-dev)
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "${PROJECT_DESCRIPTION}: libraries
Headers, static libraries and CMake's description of them, to add laws and
terms to Pliant or to call it from another program.")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
string(JOIN ", " CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "pliant (= ${PROJECT_VERSION})" g++ cmake pkg-config
       libpetsc-real-dev libslepc-real-dev libgmsh-dev libmetis-dev libhdf5-openmpi-dev libopenmpi-dev libyaml-cpp-dev
       libcli11-dev libfmt-dev libmuparser-dev libudunits2-dev nlohmann-json3-dev libeigen3-dev libboost-dev zlib1g-dev)

# A program for this machine's instruction set ends with an illegal instruction on an older one.
if(PLIANT_NATIVE)
  set(CPACK_PROJECT_CONFIG_FILE ${CMAKE_BINARY_DIR}/native-package.cmake)
  file(WRITE ${CPACK_PROJECT_CONFIG_FILE} "message(WARNING \"This package runs on processors like this one only; for \
any: cmake --preset package && cmake --build --preset package && cpack --preset package\")\n")
endif()
include(CPack)
