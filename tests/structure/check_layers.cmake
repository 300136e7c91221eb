# cmake -DROOT=<source tree> -P check_layers.cmake
#
# The layering rule: a room includes only itself and rooms above it. Fails with one line for each include
# that breaks it. Looked at are the include directives in include/recon/ and src/:
#   include/recon/<room>/   public headers, as "recon/<room>/..."; of other projects the standard
#                           library, Eigen, and Boost in the one header that is about Boost types
#   src/<room>/             public headers, and private ones as "<room>/..." or of the same folder
#   include/recon/*.hpp     belong to recon::recon: rooms from core to transfer
#   src/programs/           public headers and files of the same folder
# Boost and nanoflann, which recon::recon can be built without, are included in one file each.
# petsc/ and ranks/ are optional components: no other room includes them, nor PETSc or MPI.
# The method, mpm/, knows neither files nor formulas nor what reads them.
cmake_minimum_required(VERSION 3.22)

set(rooms core points neighbourhood weights basis local_solve shape operators grid transfer petsc mpm fields io runs studies
  ranks bindings c python)
set(last_of_recon transfer)
set(headers_about_boost include/recon/points/boost_geometry.hpp)
set(includes_boost src/neighbourhood/r_tree.cpp)
set(includes_nanoflann src/neighbourhood/nanoflann_tree.hpp)

file(GLOB_RECURSE files RELATIVE ${ROOT} ${ROOT}/include/recon/* ${ROOT}/src/*)
list(FILTER files INCLUDE REGEX "\\.(hpp|cpp|h|cc|cu|cuh|inl|ipp)$")
if(NOT files)
  message(FATAL_ERROR "no source files under '${ROOT}'")
endif()

set(complaints "")
macro(complain reason)
  string(APPEND complaints "\n  ${file} includes ${included}: ${reason}")
endmacro()

foreach(file IN LISTS files)
  # Who includes: its room, how deep that lies, and whether it is public.
  string(REGEX MATCH "^(include/recon|src)/(([^/]+)/)?" folder "${file}")
  set(public ${CMAKE_MATCH_1})
  set(room "${CMAKE_MATCH_3}")
  set(place "${room}")
  if(room STREQUAL "" AND public STREQUAL "include/recon")
    list(FIND rooms ${last_of_recon} depth)
    set(place ${last_of_recon})
  elseif(room STREQUAL "programs" AND public STREQUAL "src")
    list(LENGTH rooms depth)
  else()
    list(FIND rooms "${room}" depth)
  endif()
  if(depth EQUAL -1)
    string(APPEND complaints "\n  ${file}: '${room}' is not a room")
    continue()
  endif()
  get_filename_component(own_folder ${ROOT}/${file} DIRECTORY)

  file(READ ${ROOT}/${file} text)
  string(REGEX MATCHALL "(^|\n)[ \t]*#[ \t]*include[ \t]*[<\"][^>\"\n]+" directives "${text}")
  foreach(directive IN LISTS directives)
    string(REGEX REPLACE "^[^<\"]*([<\"])(.*)$" "\\1" mark "${directive}")
    string(REGEX REPLACE "^[^<\"]*([<\"])(.*)$" "\\2" included "${directive}")
    if(included MATCHES "(^|/)\\.\\.?/")
      complain("no relative paths")
      continue()
    endif()
    if(public STREQUAL "include/recon" AND included MATCHES "^(boost/|nanoflann|omp\\.h|zlib\\.h|CLI/)" AND
       NOT (included MATCHES "^boost/" AND file IN_LIST headers_about_boost))
      complain("public headers do not pull this in")
      continue()
    endif()
    if(NOT room MATCHES "^(petsc|ranks|programs)$" AND
       included MATCHES "^(mpi\\.h|petsc[a-z]*\\.h|recon/petsc/|petsc/|recon/ranks/|ranks/)")
      complain("only petsc/ and ranks/ include this: recon can be built without it")
      continue()
    endif()
    if(room STREQUAL "mpm" AND included MATCHES "^(filesystem|fstream|iostream|boost/|hdf5|muParser|toml)")
      complain("the method knows no files")
      continue()
    endif()
    if(public STREQUAL "src" AND NOT room STREQUAL "runs" AND included MATCHES "^(boost|nanoflann)")
      if(NOT file STREQUAL "${includes_${CMAKE_MATCH_1}}")
        complain("recon can be built without this")
      endif()
      continue()
    endif()

    # What is included: a header of this project, or none of its business.
    if(included MATCHES "^recon/([^/]+)/")
      set(used ${CMAKE_MATCH_1})
    elseif(included MATCHES "^recon/")
      if(NOT room STREQUAL "programs")
        complain("rooms do not include the umbrella header")
      endif()
      continue()
    elseif(mark STREQUAL "\"" AND included MATCHES "^([^/]+)/")
      set(used ${CMAKE_MATCH_1})
      if(public STREQUAL "include/recon")
        complain("public headers include public headers only")
        continue()
      elseif(room STREQUAL "programs" AND NOT used STREQUAL "programs")
        complain("programs use public headers only")
        continue()
      endif()
    elseif(mark STREQUAL "\"" AND NOT EXISTS ${own_folder}/${included})
      complain("no such file in this folder")
      continue()
    else()
      continue()
    endif()
    if(used STREQUAL room)
      continue()
    endif()
    list(FIND rooms "${used}" used_depth)
    if(used_depth EQUAL -1)
      complain("'${used}' is not a room")
    elseif(used_depth GREATER depth)
      complain("'${used}' comes after '${place}'")
    endif()
  endforeach()
endforeach()

if(complaints)
  message(FATAL_ERROR "The layering rule is broken:${complaints}")
endif()
list(LENGTH files count)
message(STATUS "${count} files keep the layering rule")
