# cmake -DTEXT=<text> -P check_refusal.cmake -- compiler arguments...
#
# The compiler refuses a file, and the first line that it calls an error has the text.
cmake_minimum_required(VERSION 3.22)

include(${CMAKE_CURRENT_LIST_DIR}/command_line.cmake)

execute_process(COMMAND ${command} RESULT_VARIABLE result OUTPUT_QUIET ERROR_VARIABLE errors)
if(result EQUAL 0)
  message(FATAL_ERROR "compiled, and should not: ${command}")
endif()
if(NOT errors MATCHES "[^\n]*error: [^\n]*")
  message(FATAL_ERROR "${command}: ${errors}")
endif()
set(first "${CMAKE_MATCH_0}")
string(FIND "${first}" "${TEXT}" found)
if(found EQUAL -1)
  message(FATAL_ERROR "the first error is not '${TEXT}', but\n${errors}")
endif()
message(STATUS "${first}")
