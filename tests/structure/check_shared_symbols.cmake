# cmake -DNM=<nm> -DSETS=<set;...> -DOBJECTS_<set>=<object;...> -P check_shared_symbols.cmake
#
# Objects compiled for an instruction set must not define weak functions of ordinary types: of several
# copies the linker keeps one for the whole program, perhaps one that the processor cannot run. A weak
# function is harmless if its name shows what it belongs to: the namespace of the set, or a pack of its width.
cmake_minimum_required(VERSION 3.22)

set(own_avx2 "avx2::|_VecBuiltin<32")
set(own_avx512 "avx512::|_VecBltnBtmsk<64")
set(complaints "")
set(functions 0)
foreach(set IN LISTS SETS)
  foreach(object IN LISTS OBJECTS_${set})
    execute_process(COMMAND ${NM} --defined-only -C ${object} OUTPUT_VARIABLE symbols RESULT_VARIABLE failed)
    if(failed)
      message(FATAL_ERROR "${NM} cannot read ${object}")
    endif()
    string(REGEX MATCHALL "[^\n]* W [^\n]*" weak "${symbols}")
    foreach(symbol IN LISTS weak)
      math(EXPR functions "${functions} + 1")
      if(NOT symbol MATCHES "${own_${set}}")
        string(REGEX REPLACE "^[0-9a-f]* W " "" symbol "${symbol}")
        get_filename_component(file ${object} NAME)
        string(APPEND complaints "\n  ${set}, ${file}: ${symbol}")
      endif()
    endforeach()
  endforeach()
endforeach()
if(complaints)
  message(FATAL_ERROR "Functions that the whole program would share:${complaints}")
endif()
message(STATUS "${functions} weak functions, all of their own set")
