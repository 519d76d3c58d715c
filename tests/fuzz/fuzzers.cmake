# libFuzzer's programs, one per reader (tools/fuzz.sh builds and runs them). Clang only.
if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
  message(FATAL_ERROR "PLIANT_FUZZ needs clang 16 or later: -DCMAKE_CXX_COMPILER=clang++-16")
endif()

# pliant_fuzzer(<name> <function> <source> <library>...)
function(pliant_fuzzer name function source)
  add_executable(fuzz_${name} ${CMAKE_CURRENT_SOURCE_DIR}/fuzz/fuzzer.cpp ${CMAKE_CURRENT_SOURCE_DIR}/fuzz/${source})
  target_compile_definitions(fuzz_${name} PRIVATE PLIANT_FUZZ_TARGET=${function})
  target_include_directories(fuzz_${name} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
  target_link_libraries(fuzz_${name} PRIVATE ${ARGN})
  target_link_options(fuzz_${name} PRIVATE -fsanitize=fuzzer)
endfunction()

# What reads inputs, and the laws whose moduli it checks, whose kernels would take a quarter of an hour to compile with
# clang's sanitizers.
file(GLOB input_sources CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/src/input/*.cpp ${CMAKE_SOURCE_DIR}/src/input/*/*.cpp)
set(beside material/constants material/law_field material/law_info material/library material/loading material/registry
           material/viscosity_registry material/volume_split)
list(TRANSFORM beside REPLACE "(.+)" "${CMAKE_SOURCE_DIR}/src/\\1.cpp")
set_source_files_properties(${CMAKE_SOURCE_DIR}/src/material/law_field.cpp PROPERTIES COMPILE_OPTIONS -fno-sanitize=all)
add_library(pliant_fuzzed_input STATIC ${input_sources} ${beside})
target_link_libraries(pliant_fuzzed_input PUBLIC pliant_time yaml-cpp nlohmann_json::nlohmann_json)

pliant_fuzzer(input read_as_input input.cpp pliant_fuzzed_input)
pliant_fuzzer(fit read_as_fit fit.cpp pliant_study)
pliant_fuzzer(msh read_as_msh meshes.cpp pliant_mesh)
foreach(name abaqus nastran medit unv vtk vtu med)
  pliant_fuzzer(${name} read_as_${name} meshes.cpp pliant_mesh)
endforeach()
pliant_fuzzer(mesh_file read_as_mesh_file meshes.cpp pliant_mesh)
pliant_fuzzer(checkpoint read_as_checkpoint checkpoint.cpp pliant_io)
pliant_fuzzer(surface read_as_surface meshes.cpp pliant_mesh)
pliant_finds_gmsh(fuzz_surface)
pliant_fuzzer(triangles read_as_triangles triangles.cpp pliant_fem)
pliant_fuzzer(result read_as_result results.cpp pliant_io)
foreach(name mesh_file med result)
  target_sources(fuzz_${name} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/fuzz/in_place/child_process.cpp)  # instead of the library's
endforeach()
