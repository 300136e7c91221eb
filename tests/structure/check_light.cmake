# cmake -P check_light.cmake -- compiler arguments...
#
# What `#include <recon/recon.hpp>` pulls in, asked from the compiler: neither Boost nor nanoflann, nor OpenMP.
cmake_minimum_required(VERSION 3.22)

include(${CMAKE_CURRENT_LIST_DIR}/command_line.cmake)

execute_process(COMMAND ${command} RESULT_VARIABLE result OUTPUT_VARIABLE files ERROR_VARIABLE error)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "${command}: ${error}")
endif()
string(REGEX MATCHALL "[^ \\\n]+" files "${files}")
list(LENGTH files count)
if(NOT files MATCHES "recon/operators/reconstruct.hpp")
  message(FATAL_ERROR "not the dependencies of recon.hpp: ${files}")
endif()
list(FILTER files INCLUDE REGEX "boost|nanoflann|/omp\\.h")
if(files)
  message(FATAL_ERROR "recon.hpp pulls in ${files}")
endif()
message(STATUS "recon.hpp and the ${count} files it pulls in: neither Boost nor nanoflann nor OpenMP")
