# cmake -DNM=<nm> -DCXX=<compiler> -DSCRIPT=<version script> -DSCRATCH=<folder> -DLIBRARIES=<archive;...> -DFLAGS=<flags>
#   -P check_exported_symbols.cmake
#
# A shared library of recon shows its own names and no others: what stands behind compiled code (Boost, nanoflann, toml++,
# Eigen's products) must not meet other versions of the same packages in the program that loads it. Made of the objects
# of the static libraries, which are compiled to go into either.
cmake_minimum_required(VERSION 3.22)

file(MAKE_DIRECTORY ${SCRATCH})
foreach(library IN LISTS LIBRARIES)
  get_filename_component(name ${library} NAME_WE)
  set(shared ${SCRATCH}/${name}.so)
  execute_process(COMMAND ${CXX} -shared -o ${shared} -Wl,--whole-archive ${library} -Wl,--no-whole-archive
    -Wl,--version-script=${SCRIPT} ${FLAGS} RESULT_VARIABLE failed)
  if(failed)
    message(FATAL_ERROR "${CXX} cannot make ${shared}")
  endif()
  execute_process(COMMAND ${NM} -D -C --defined-only ${shared} OUTPUT_VARIABLE symbols RESULT_VARIABLE failed)
  string(REGEX MATCHALL "[^\n]*recon::[^\n]*" own "${symbols}")
  string(REGEX REPLACE "[^\n]*recon(::|_)[^\n]*\n" "" others "${symbols}")
  list(LENGTH own count)
  if(failed OR count LESS 100)
    message(FATAL_ERROR "${shared} shows ${count} of recon's names")
  endif()
  if(others)
    message(FATAL_ERROR "${shared} shows what is not recon's:\n${others}")
  endif()
  message(STATUS "${name}: ${count} names")
endforeach()
