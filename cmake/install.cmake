# What `cmake --install` puts where: the program with its data, and the libraries for other programs, which find them with
# find_package(pliant) (docs/developer/extending.md).
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(PLIANT_LAYERS base petsc material collision mesh fem time energy multigrid solver io input model run study command)
set(pliant_cmake ${CMAKE_INSTALL_LIBDIR}/cmake/pliant)
set(pliant_share ${CMAKE_INSTALL_DATADIR}/pliant)

# The program. lib/pliant is where its run path leads, whatever the system calls its folder of libraries.
install(TARGETS pliant_program RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
install(TARGETS pliant_gmsh LIBRARY DESTINATION lib/pliant COMPONENT program)
install(DIRECTORY input meshes docs DESTINATION ${pliant_share} COMPONENT program
        PATTERN "conf.py" EXCLUDE PATTERN "site.css" EXCLUDE PATTERN "Doxyfile" EXCLUDE PATTERN "headers.sed" EXCLUDE PATTERN "__pycache__" EXCLUDE)
# Where the program is installed, its documents call it by its name; install.md is about building it.
install(CODE "set(pages_in \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${pliant_share}/docs\")" COMPONENT program)
install(CODE [[
  file(GLOB pages "${pages_in}/*.md")
  list(REMOVE_ITEM pages "${pages_in}/install.md")
  foreach(page ${pages})
    file(READ "${page}" text)
    string(REPLACE "build/bin/pliant" "pliant" text "${text}")
    file(WRITE "${page}" "${text}")
  endforeach()
]] COMPONENT program)
# The Python package, where Debian's interpreter looks if the prefix is /usr, and the program for `render` and `plot`: in
# ../lib/python3/dist-packages from its own folder, as in the folder of the build.
install(DIRECTORY src/python/pliant DESTINATION lib/python3/dist-packages COMPONENT program
        FILES_MATCHING PATTERN "*.py" PATTERN "py.typed" PATTERN "__pycache__" EXCLUDE)
file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/lib/python3/dist-packages)
file(CREATE_LINK ${CMAKE_SOURCE_DIR}/src/python/pliant ${CMAKE_BINARY_DIR}/lib/python3/dist-packages/pliant SYMBOLIC)
install(PROGRAMS tools/work_precision.py tools/beam_mesh.py DESTINATION ${pliant_share}/tools COMPONENT program)
install(FILES tools/package.py DESTINATION ${pliant_share}/tools COMPONENT program)
# Beside the documents, whose links lead there; the change log where Debian looks for it, too.
install(FILES README.md CHANGELOG.md CITATION.cff CONTRIBUTING.md LICENSE DESTINATION ${pliant_share} COMPONENT program)
install(FILES CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)
install(FILES src/shell/pliant.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT program
        RENAME pliant)
install(FILES src/shell/pliant.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program RENAME copyright)  # Debian's name for it

# The libraries: one target per layer, pliant::base to pliant::command, and pliant::pliant for all of them.
add_library(pliant_pliant INTERFACE)
target_link_libraries(pliant_pliant INTERFACE pliant_command)
foreach(layer options ${PLIANT_LAYERS} pliant)
  set_target_properties(pliant_${layer} PROPERTIES EXPORT_NAME ${layer})
  install(TARGETS pliant_${layer} EXPORT pliant-targets
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)
endforeach()
install(DIRECTORY src/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/pliant COMPONENT development
        FILES_MATCHING PATTERN "*.hpp" PATTERN "viewer" EXCLUDE PATTERN "python" EXCLUDE)
install(EXPORT pliant-targets NAMESPACE pliant:: DESTINATION ${pliant_cmake} COMPONENT development)

configure_package_config_file(cmake/pliant-config.cmake.in ${CMAKE_BINARY_DIR}/pliant-config.cmake
                              INSTALL_DESTINATION ${pliant_cmake})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/pliant-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/pliant-config.cmake ${CMAKE_BINARY_DIR}/pliant-config-version.cmake
              ${CMAKE_SOURCE_DIR}/cmake/packages.cmake DESTINATION ${pliant_cmake} COMPONENT development)
