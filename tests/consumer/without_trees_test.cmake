# Configures recon where neither Boost nor nanoflann can be found: an error that names the package and the option of
# the build, unless the option is off; then a configuration whose package file says so.
cmake_minimum_required(VERSION 3.22)

# configure(options...): into `result` and `output`.
function(configure)
  execute_process(
    COMMAND ${CMAKE_COMMAND} -S ${SOURCE} -B ${SCRATCH} --fresh -G ${GENERATOR} -DCMAKE_CXX_COMPILER=${COMPILER}
      -DCMAKE_DISABLE_FIND_PACKAGE_Boost=ON -DCMAKE_DISABLE_FIND_PACKAGE_nanoflann=ON -DRECON_BUILD_IO=OFF
      -DRECON_BUILD_MPM=OFF -DRECON_BUILD_PROGRAMS=OFF -DRECON_BUILD_EXAMPLES=OFF ${ARGN}
    RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  string(REGEX REPLACE "[ \n]+" " " output "${output}")  # messages are wrapped
  set(result "${result}" PARENT_SCOPE)
  set(output "${output}" PARENT_SCOPE)
endfunction()

function(check_refused package option)
  configure(${ARGN})
  if(result EQUAL 0 OR NOT output MATCHES "recon: ${package} [0-9.]+ or newer was not found; -D${option}=OFF builds without")
    message(SEND_ERROR "no ${package}, and yet: ${result}, ${output}")
  endif()
endfunction()

check_refused(Boost RECON_WITH_BOOST)
check_refused(nanoflann RECON_WITH_NANOFLANN -DRECON_WITH_BOOST=OFF)

configure(-DRECON_WITH_BOOST=OFF -DRECON_WITH_NANOFLANN=OFF)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "without both: ${output}")
endif()
file(READ ${SCRATCH}/reconConfig.cmake package)
foreach(option RECON_WITH_BOOST RECON_WITH_NANOFLANN)
  if(NOT package MATCHES "set\\(${option} OFF\\)")
    message(SEND_ERROR "the package file does not say that ${option} is off: ${package}")
  endif()
endforeach()
