# cmake -DSCRATCH=<folder> -P check_layers_test.cmake
#
# check_layers.cmake on small trees: one that is clean, then the same with one violation each.
cmake_minimum_required(VERSION 3.22)

# check(reason path content): with the file `path` added to the clean tree the rule is broken, and the
# complaint names the file and the reason. An empty reason: it is not broken.
function(check reason path content)
  file(REMOVE_RECURSE ${SCRATCH})
  file(WRITE ${SCRATCH}/include/recon/recon.hpp "#include \"recon/points/view.hpp\"\n")
  file(WRITE ${SCRATCH}/include/recon/core/error.hpp "#pragma once\n#include <string>\n")
  file(WRITE ${SCRATCH}/include/recon/points/view.hpp
    "#include <Eigen/Core>\n\n#include \"recon/core/error.hpp\"\n// #include \"recon/io/read.hpp\"\n")
  file(WRITE ${SCRATCH}/src/points/private.hpp "#pragma once\n")
  file(WRITE ${SCRATCH}/src/points/view.cpp
    "#include \"points/private.hpp\"\n#include \"private.hpp\"\n")
  file(WRITE ${SCRATCH}/src/programs/main.cpp "#include \"recon/recon.hpp\"\n#include <CLI/CLI.hpp>\n")
  if(path)
    file(WRITE ${SCRATCH}/${path} "${content}\n")
  endif()
  execute_process(COMMAND ${CMAKE_COMMAND} -DROOT=${SCRATCH} -P ${CMAKE_CURRENT_LIST_DIR}/check_layers.cmake
    RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT reason AND NOT result EQUAL 0)
    message(SEND_ERROR "refused, but is clean: ${path} with ${content}: ${output}")
  elseif(reason AND result EQUAL 0)
    message(SEND_ERROR "not noticed: ${path} with ${content}")
  elseif(reason)
    string(REGEX REPLACE "[ \n]+" " " output "${output}")  # messages are wrapped
    string(FIND "${output}" "${path}" names_file)
    string(FIND "${output}" "${reason}" names_reason)
    if(names_file EQUAL -1 OR names_reason EQUAL -1)
      message(SEND_ERROR "does not say '${path}' and '${reason}': ${output}")
    endif()
  endif()
endfunction()

set(after "'points' comes after 'core'")
check("" "" "")
check("" src/io/a.cpp "#include <recon/points/view.hpp>")
check("" include/recon/points/boost_geometry.hpp "#include <boost/geometry/core/access.hpp>")
check("${after}" include/recon/core/a.hpp "#include \"recon/points/view.hpp\"")
check("${after}" include/recon/core/a.hpp "#pragma once\n  #  include <recon/points/view.hpp>")
check("${after}" include/recon/core/detail/a.hpp "#include \"recon/points/view.hpp\"")
check("${after}" src/core/a.cpp "#include \"recon/points/view.hpp\"")
check("${after}" src/core/a.cpp "#include \"points/private.hpp\"")
check("'io' comes after 'transfer'" include/recon/recon.hpp "#include \"recon/io/read.hpp\"")
check("'attic' is not a room" include/recon/attic/a.hpp "#pragma once")
check("'attic' is not a room" src/points/a.cpp "#include \"recon/attic/a.hpp\"")
check("no relative paths" src/points/a.cpp "#include \"../core/a.hpp\"")
check("no such file in this folder" src/points/a.cpp "#include \"absent.hpp\"")
check("rooms do not include the umbrella header" src/points/a.cpp "#include \"recon/recon.hpp\"")
check("public headers include public headers only" include/recon/points/a.hpp "#include \"points/private.hpp\"")
check("public headers do not pull this in" include/recon/points/a.hpp "#include <nanoflann.hpp>")
check("public headers do not pull this in" include/recon/points/a.hpp "#include <boost/geometry.hpp>")
check("" src/neighbourhood/r_tree.cpp "#include <boost/geometry.hpp>")
check("" src/mpm/a.cpp "#include <boost/geometry.hpp>")
check("recon can be built without this" src/points/a.cpp "#include <boost/geometry.hpp>")
check("recon can be built without this" src/neighbourhood/r_tree.cpp "#include <nanoflann.hpp>")
check("programs use public headers only" src/programs/a.cpp "#include \"points/private.hpp\"")
