# The page of `pliant report`: src/viewer/ with its libraries from npm, bundled into one file of HTML. The registry of npm
# is asked at build time, once; nobody asks it when a report is made or looked at. As a script (cmake -P) it makes the page.
if(CMAKE_SCRIPT_MODE_FILE)
  # Without the network there is a program without reports, rather than no program.
  function(give_up what output)
    file(WRITE ${PAGE} "")
    string(STRIP "${output}" output)
    message(WARNING "${what}; `pliant report` will not work. To try again: touch src/viewer/package.json; to build "
                    "without it: cmake -DPLIANT_REPORT=OFF\n${output}")
  endfunction()

  file(MAKE_DIRECTORY ${WORK})
  file(COPY ${SOURCE}/package.json ${SOURCE}/package-lock.json DESTINATION ${WORK})
  # Exactly the locked versions. Scripts of packages are not run.
  execute_process(COMMAND ${NPM} ci --ignore-scripts --no-audit --no-fund --loglevel=error WORKING_DIRECTORY ${WORK}
                  RESULT_VARIABLE failed OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(failed)
    give_up("npm could not get the libraries of the viewer" "${output}")
    return()
  endif()
  execute_process(
    COMMAND ${CMAKE_COMMAND} -E env NODE_PATH=${WORK}/node_modules ${WORK}/node_modules/.bin/esbuild ${SOURCE}/main.js
            --bundle --minify --format=iife --target=es2020 --legal-comments=inline --log-level=warning
            --outfile=${WORK}/viewer.js
    RESULT_VARIABLE failed OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(failed)
    message(FATAL_ERROR "the viewer could not be bundled\n${output}")
  endif()
  file(READ ${SOURCE}/page.html page)
  file(READ ${WORK}/viewer.js code)
  file(READ ${WORK}/viewer.css style)
  set(licenses "")
  foreach(library three uplot)
    file(READ ${WORK}/node_modules/${library}/LICENSE license)
    string(APPEND licenses "${library}\n\n${license}\n")
  endforeach()
  # A script ends at the first "</script", wherever it stands.
  string(REPLACE "</script" "<\\/script" code "${code}")
  string(REPLACE "/* the style */" "${style}" page "${page}")
  string(REPLACE "/* the code */" "${code}" page "${page}")
  string(REPLACE "<!-- the licenses -->" "${licenses}" page "${page}")
  file(WRITE ${PAGE} "${page}")
  return()
endif()

# pliant_report_page(): command/report_page.cpp embeds the page.
function(pliant_report_page)
  find_program(NPM npm)
  option(PLIANT_REPORT "Build the page of `pliant report`; needs npm" ON)
  if(NOT PLIANT_REPORT OR NOT NPM)
    if(PLIANT_REPORT)
      message(STATUS "npm was not found: the program is built without `pliant report`")
    endif()
    return()
  endif()
  set(page ${CMAKE_BINARY_DIR}/viewer/report.html)
  set(source ${CMAKE_SOURCE_DIR}/src/viewer)
  file(GLOB sources CONFIGURE_DEPENDS ${source}/*)
  add_custom_command(
    OUTPUT ${page}
    COMMAND ${CMAKE_COMMAND} -DNPM=${NPM} -DSOURCE=${source} -DWORK=${CMAKE_BINARY_DIR}/viewer -DPAGE=${page} -P
            ${CMAKE_SOURCE_DIR}/cmake/viewer.cmake
    DEPENDS ${sources} ${CMAKE_SOURCE_DIR}/cmake/viewer.cmake
    COMMENT "Bundling the viewer of reports"
    VERBATIM)
  set_source_files_properties(
    ${CMAKE_CURRENT_SOURCE_DIR}/command/report_page.cpp
    PROPERTIES OBJECT_DEPENDS ${page} COMPILE_DEFINITIONS PLIANT_REPORT_PAGE="${page}")
endfunction()
