# One library per layer, so that a layer links only what it may include (see tools/check_layers.py).
add_library(pliant_options INTERFACE)
target_compile_features(pliant_options INTERFACE cxx_std_20)
# The three warnings left out have false positives in the C++20 strings of g++ 12 and in fmt 9.
target_compile_options(pliant_options INTERFACE
                       "$<BUILD_INTERFACE:-Wall;-Wextra;-Wpedantic;-Wshadow;-Wnon-virtual-dtor;-Werror>" -Wno-psabi
                       "$<BUILD_INTERFACE:-Wno-restrict;-Wno-maybe-uninitialized;-Wno-stringop-overflow>" -fno-math-errno)
if(PLIANT_NATIVE)
  # The size of a pack is part of every interface: programs on the installed libraries take the same instruction set.
  target_compile_options(pliant_options INTERFACE -march=native)
endif()
# Python's module and that of gmsh are shared libraries of these layers. Debian's g++ makes position-independent executables
# anyway; without interposition the code is the same.
target_compile_options(pliant_options INTERFACE $<BUILD_INTERFACE:-fno-semantic-interposition>)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
if(PLIANT_SANITIZE)
  # Under the sanitizers g++ 12 warns of its own vector intrinsics. The checks of each pointer let a file of kernels take
  # minutes and gigabytes to compile, and find nothing that the address sanitizer does not.
  target_compile_options(pliant_options INTERFACE -fsanitize=${PLIANT_SANITIZE} -fno-omit-frame-pointer
                         -fno-sanitize=null,alignment,object-size,vptr -fno-sanitize-recover=undefined -Wno-uninitialized)
  target_link_options(pliant_options INTERFACE -fsanitize=${PLIANT_SANITIZE})
  # An index beyond a vector's size that is within its capacity is no wrong address.
  target_compile_definitions(pliant_options INTERFACE _GLIBCXX_ASSERTIONS)
endif()
if(PLIANT_COVERAGE)
  target_compile_options(pliant_options INTERFACE --coverage -Wno-uninitialized)  # as above
  target_link_options(pliant_options INTERFACE --coverage)
endif()
if(PLIANT_FUZZ)
  # Every edge is counted; clang knows other warnings than g++, which is the compiler that warns.
  target_compile_options(pliant_options INTERFACE -fsanitize=fuzzer-no-link -Wno-error -w)
endif()
target_compile_definitions(pliant_options INTERFACE OMPI_SKIP_MPICXX)
target_include_directories(pliant_options INTERFACE $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}/src>
                                                    $<INSTALL_INTERFACE:include/pliant>)

# pliant_kernels(<target>...): what instantiates the laws. Under the sanitizers g++ would watch the place of every temporary
# pack and check every step of a pointer, and compile such a file five times as long; indices of arrays are checked still.
# As options of the sources they come after those that they take back.
function(pliant_kernels)
  if(PLIANT_SANITIZE AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    foreach(target ${ARGN})
      get_target_property(sources ${target} SOURCES)
      set_source_files_properties(
        ${sources} PROPERTIES COMPILE_OPTIONS "--param=asan-stack=0;-fno-sanitize-address-use-after-scope;\
-fno-sanitize=pointer-overflow,shift;-U_GLIBCXX_ASSERTIONS")
    endforeach()
  endif()
endfunction()

# pliant_layer(<name> <dependency>...): src/<name>/ with its rooms as the library pliant_<name>; a layer without sources is
# headers only.
function(pliant_layer name)
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/src/${name}/*.cpp)
  list(FILTER sources EXCLUDE REGEX "/(main\\.cpp|mesh/gmsh/.*)$")
  if(sources)
    add_library(pliant_${name} STATIC ${sources})
    target_link_libraries(pliant_${name} PUBLIC pliant_options ${ARGN})
  else()
    add_library(pliant_${name} INTERFACE)
    target_link_libraries(pliant_${name} INTERFACE pliant_options ${ARGN})
  endif()
endfunction()

# src/mesh/gmsh/*.cpp with libgmsh as a library that programs load when they first need it (mesh/gmsh_module.hpp).
function(pliant_gmsh_module)
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/src/mesh/gmsh/*.cpp)
  add_library(pliant_gmsh MODULE ${sources})
  target_link_libraries(pliant_gmsh PRIVATE pliant_mesh ${GMSH_LIBRARY})
  set_target_properties(pliant_gmsh PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib)
  # Programs on the installed libraries find it as pliant itself does.
  target_link_options(pliant_mesh INTERFACE $<INSTALL_INTERFACE:-Wl,-rpath,$<INSTALL_PREFIX>/lib/pliant>)
endfunction()

# src/binding/*.cpp as the module _pliant of Python, next to the package pliant; where pybind11 and Python's headers are.
function(pliant_python_module)
  option(PLIANT_PYTHON "Build the module of Python; needs pybind11" ON)
  if(PLIANT_PYTHON)
    if(NOT Python3_EXECUTABLE AND EXISTS /usr/bin/python3)
      set(Python3_EXECUTABLE /usr/bin/python3)  # Debian's, for which its modules are; another one may come first on PATH
    endif()
    find_package(Python3 QUIET COMPONENTS Interpreter Development.Module)
    find_path(PYBIND11_INCLUDE_DIR pybind11/pybind11.h)
  endif()
  if(NOT PLIANT_PYTHON OR NOT Python3_Development.Module_FOUND OR NOT PYBIND11_INCLUDE_DIR)
    if(PLIANT_PYTHON)
      message(STATUS "pybind11 or Python's headers were not found: there is no pliant.Simulation in Python")
    endif()
    return()
  endif()
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/src/binding/*.cpp)
  add_library(pliant_python MODULE ${sources})
  target_link_libraries(pliant_python PRIVATE pliant_run Python3::Module)
  target_include_directories(pliant_python SYSTEM PRIVATE ${PYBIND11_INCLUDE_DIR})
  target_compile_options(pliant_python PRIVATE $<$<CONFIG:Release>:-O1>)
  set_target_properties(
    pliant_python PROPERTIES OUTPUT_NAME _pliant PREFIX "" SUFFIX ".${Python3_SOABI}.so" CXX_VISIBILITY_PRESET hidden
    LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib/python3/dist-packages)
  # The symbols of the layers stay inside: another module may bring other versions of the same libraries.
  target_link_options(pliant_python PRIVATE -Wl,--exclude-libs,ALL)
  pliant_finds_gmsh(pliant_python)
  set_target_properties(pliant_python PROPERTIES INSTALL_RPATH "$ORIGIN/../../pliant")
  install(TARGETS pliant_python LIBRARY DESTINATION lib/python3/dist-packages COMPONENT program)
endfunction()

# pliant_finds_gmsh(<program>): the program finds that library, built or installed.
function(pliant_finds_gmsh program)
  add_dependencies(${program} pliant_gmsh)
  set_target_properties(${program} PROPERTIES BUILD_RPATH ${CMAKE_BINARY_DIR}/lib INSTALL_RPATH "$ORIGIN/../lib/pliant"
                        INSTALL_RPATH_USE_LINK_PATH ON)
endfunction()
