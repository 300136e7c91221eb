# Installs recon from RECON_BUILD, moves the installation, and configures, builds and runs SOURCE with it,
# where nothing but Eigen can be found of what recon was built with. Then other ways to the same installation: components,
# and pkg-config.
cmake_minimum_required(VERSION 3.22)

function(run what)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${what}: ${result}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE ${SCRATCH})
run("Installing" ${CMAKE_COMMAND} --install ${RECON_BUILD} --config ${CONFIG} --prefix ${SCRATCH}/installed)
file(RENAME ${SCRATCH}/installed ${SCRATCH}/prefix)

# The files of the installation name no folder of the build or source tree.
get_filename_component(root ${SOURCE}/../.. ABSOLUTE)
file(GLOB_RECURSE package ${SCRATCH}/prefix/*.cmake ${SCRATCH}/prefix/*.pc)
if(NOT package)
  message(FATAL_ERROR "nothing installed for find_package")
endif()
foreach(file IN LISTS package)
  file(READ ${file} text)
  foreach(folder ${root} ${RECON_BUILD} ${SCRATCH}/installed "/usr/")
    string(FIND "${text}" "${folder}" found)
    if(NOT found EQUAL -1)
      message(SEND_ERROR "${file} names ${folder}")
    endif()
  endforeach()
endforeach()

set(without)
foreach(name Boost nanoflann GTest CLI11 ZLIB muparser)
  list(APPEND without -DCMAKE_DISABLE_FIND_PACKAGE_${name}=ON)
endforeach()
set(flags "-Wall -Wextra -Werror")
if(SANITIZE)
  string(APPEND flags " -fsanitize=${SANITIZE}")
endif()
run("Configuring" ${CMAKE_COMMAND} -S ${SOURCE} -B ${SCRATCH}/build -G ${GENERATOR}
  -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_FLAGS=${flags}
  -DCMAKE_PREFIX_PATH=${SCRATCH}/prefix ${without})
file(STRINGS ${SCRATCH}/build/CMakeCache.txt used REGEX "^recon_DIR:")
if(NOT used MATCHES "${SCRATCH}/prefix")
  message(FATAL_ERROR "another recon was found: ${used}")
endif()
run("Building" ${CMAKE_COMMAND} --build ${SCRATCH}/build)
run("Running" ${SCRATCH}/build/consumer)
message(STATUS "${output}")

# ---- components ----

set(project ${CMAKE_COMMAND} -S ${SOURCE}/components -B ${SCRATCH}/components --fresh -G ${GENERATOR}
  -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_FLAGS=${flags}
  -DCMAKE_PREFIX_PATH=${SCRATCH}/prefix)
run("Configuring with all components" ${project} "-DCOMPONENTS=${COMPONENTS}")
run("Linking all components" ${CMAKE_COMMAND} --build ${SCRATCH}/components)
run("Running with all components" ${SCRATCH}/components/consumer)

# check_refused(words arguments...): the project cannot be configured, and the words are among what it says.
function(check_refused words)
  execute_process(COMMAND ${project} ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  string(REGEX REPLACE "[ \n]+" " " output "${output}")  # messages are wrapped
  string(FIND "${output}" "${words}" found)
  if(result EQUAL 0 OR found EQUAL -1)
    message(SEND_ERROR "configured with ${ARGN}: ${result}, not '${words}' but\n${output}")
  endif()
endfunction()
string(REPLACE ";" ", " built "${BUILT}")
check_refused("component fluid: this recon was built with the components ${built}" -DCOMPONENTS=fluid)
if(STATIC AND "io" IN_LIST COMPONENTS)
  check_refused("component io: zlib was not found" -DCOMPONENTS=io -DCMAKE_DISABLE_FIND_PACKAGE_ZLIB=ON)
endif()
if(STATIC AND "mpm" IN_LIST COMPONENTS)
  check_refused("component mpm: muParser was not found" -DCOMPONENTS=mpm -DCMAKE_DISABLE_FIND_PACKAGE_muparser=ON)
endif()

# ---- pkg-config ----

find_program(PKG_CONFIG NAMES pkg-config pkgconf)
if(NOT PKG_CONFIG)
  message(STATUS "pkg-config was not found: not tried")
  return()
endif()
file(GLOB_RECURSE pc ${SCRATCH}/prefix/recon.pc)
get_filename_component(folder ${pc} DIRECTORY)
set(ENV{PKG_CONFIG_PATH} ${folder})
list(GET COMPONENTS -1 last)  # it requires the others
string(REPLACE "recon-recon" "recon" name recon-${last})
set(static)
if(STATIC)
  set(static --static)
endif()
run("pkg-config of ${name}" ${PKG_CONFIG} --cflags --libs ${static} ${name})
separate_arguments(arguments UNIX_COMMAND "${flags} ${output}")
run("Compiling with pkg-config's ${name}" ${COMPILER} -std=c++20 ${SOURCE}/main.cpp -o ${SCRATCH}/consumer_${name}
  ${arguments} -Wl,-rpath,${folder}/..)
run("Running with pkg-config's ${name}" ${SCRATCH}/consumer_${name})
