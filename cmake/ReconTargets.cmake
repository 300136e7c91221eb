# How a room becomes part of a library, and how the libraries are installed.

# Where the files of a target compile in large pieces, g++ takes the files of a piece for headers, and what one of them
# has to itself hides what the others see. What is warned of then is no fault; builds file by file look for it everywhere.
function(recon_allow_pieces target)
  if(RECON_QUICK_BUILD)
    target_compile_options(${target} PRIVATE -Wno-shadow $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
  endif()
endfunction()

# Warnings and sanitizers, for everything that is built here and nothing that consumes it.
function(recon_set_compile_options target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
    $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>  # g++ 12 sees overlap in text + std::string where none is
    $<$<BOOL:${RECON_WARNINGS_AS_ERRORS}>:-Werror>)
  if(RECON_SANITIZE)
    target_compile_options(${target} PRIVATE -fsanitize=${RECON_SANITIZE} -fno-sanitize-recover=all
      -fno-omit-frame-pointer)
    # What the address sanitizer sees where the memory is touched, or a processor where a vector lies askew, is not asked
    # of every pointer before: more than half of the time to compile would be these questions.
    if(RECON_SANITIZE MATCHES "address" AND RECON_SANITIZE MATCHES "undefined")
      target_compile_options(${target} PRIVATE -fno-sanitize=null,object-size,pointer-overflow,vptr,alignment)
    endif()
    target_link_options(${target} PRIVATE -fsanitize=${RECON_SANITIZE})
  endif()
endfunction()

# The instruction sets that *.simd.cpp files are compiled for, besides `generic`: the flags of the whole build.
# Optimised whatever the build type: the rest of the program must not get unoptimised helpers with instructions
# that the processor may lack (src/core/dispatch.hpp).
include(CheckCXXCompilerFlag)
set(RECON_INSTRUCTION_SETS avx2 avx512 CACHE STRING "Instruction sets that kernels are compiled for, besides that of the whole build")
foreach(set IN LISTS RECON_INSTRUCTION_SETS)
  if(NOT set MATCHES "^(avx2|avx512)$")
    message(FATAL_ERROR "RECON_INSTRUCTION_SETS has '${set}'; it may hold avx2 and avx512")
  endif()
endforeach()
if(avx512 IN_LIST RECON_INSTRUCTION_SETS AND NOT avx2 IN_LIST RECON_INSTRUCTION_SETS)
  message(FATAL_ERROR "RECON_INSTRUCTION_SETS has avx512, which needs avx2 beside it")
endif()
set(RECON_SETS generic)
# Loops over threads are the same for every set: the thread sanitizer needs one.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64|amd64)$" AND NOT RECON_SANITIZE MATCHES "thread")
  check_cxx_compiler_flag(-march=x86-64-v4 RECON_COMPILER_KNOWS_X86_LEVELS)
  if(RECON_COMPILER_KNOWS_X86_LEVELS AND avx2 IN_LIST RECON_INSTRUCTION_SETS)
    list(APPEND RECON_SETS avx2)
    set(RECON_SET_DEFINITIONS RECON_AVX2_SET)
  endif()
  if(RECON_COMPILER_KNOWS_X86_LEVELS AND avx512 IN_LIST RECON_INSTRUCTION_SETS)
    # With clang, std::experimental::simd of libstdc++ 12 assigns to the wrong lanes of AVX-512 registers. Under
    # sanitizers these files take longest to compile, and are what avx2 has been made of.
    if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND NOT RECON_SANITIZE)
      list(APPEND RECON_SETS avx512)
      list(APPEND RECON_SET_DEFINITIONS RECON_AVX512_SET)
    endif()
  endif()
endif()
set(RECON_FLAGS_avx2 -march=x86-64-v3)
set(RECON_FLAGS_avx512 -march=x86-64-v4 -mprefer-vector-width=512)
if(NOT RECON_SINGLE_PRECISION)
  list(APPEND RECON_SET_DEFINITIONS RECON_DOUBLE_ONLY)
endif()
if(NOT RECON_SANITIZE)
  list(APPEND RECON_FLAGS_avx2 -O3)
  list(APPEND RECON_FLAGS_avx512 -O3)
endif()

# Adds the objects of SOURCES, compiled once per instruction set, to the library.
function(recon_add_simd_sources library)
  foreach(set IN LISTS RECON_SETS)
    set(objects ${library}_${set})
    add_library(${objects} OBJECT ${ARGN})
    target_compile_features(${objects} PRIVATE cxx_std_20)
    target_include_directories(${objects} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/include ${CMAKE_CURRENT_SOURCE_DIR}/src)
    recon_set_compile_options(${objects})
    target_compile_options(${objects} PRIVATE ${RECON_FLAGS_${set}}
      "$<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized;-Wno-uninitialized>")  # g++ 12 complains of its own AVX-512 headers
    target_compile_definitions(${objects} PRIVATE RECON_SET=${set} ${RECON_SET_DEFINITIONS})
    target_sources(${library} PRIVATE $<TARGET_OBJECTS:${objects}>)
  endforeach()
  # Searches decide by squared distances that must be the same for all sets, and a run that goes on elsewhere must
  # have the same bits (what two opposite particles give to a node must be zero, too); fits gain by fusing. A sanitizer's
  # checks stand between a product and its sum, so that some copies of a loop would be fused and others not.
  foreach(source IN LISTS ARGN)
    if(source MATCHES "/(neighbourhood|transfer)/" OR RECON_SANITIZE)
      set_source_files_properties(${source} PROPERTIES COMPILE_OPTIONS -ffp-contract=off)
    else()
      set_source_files_properties(${source} PROPERTIES COMPILE_OPTIONS -ffp-contract=fast)
    endif()
  endforeach()
endfunction()

include(CheckLinkerFlag)
set(RECON_EXPORTED_SYMBOLS ${CMAKE_CURRENT_LIST_DIR}/exported_symbols.map)
check_linker_flag(CXX -Wl,--version-script=${RECON_EXPORTED_SYMBOLS} RECON_LINKER_KNOWS_VERSION_SCRIPTS)

# recon_add_library(name ROOMS room... [EXCEPT file...]): the sources are those in src/<room>/.
function(recon_add_library name)
  cmake_parse_arguments(arg "" "" "ROOMS;EXCEPT" ${ARGN})
  set(sources)
  foreach(room IN LISTS arg_ROOMS)
    file(GLOB room_sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/src/${room}/*.cpp)
    list(APPEND sources ${room_sources})
  endforeach()
  foreach(file IN LISTS arg_EXCEPT)
    list(REMOVE_ITEM sources ${CMAKE_CURRENT_SOURCE_DIR}/${file})
  endforeach()
  if(NOT RECON_SINGLE_PRECISION)
    list(FILTER sources EXCLUDE REGEX "_float(_[123]d)?(\\.simd)?\\.cpp$")
  endif()
  set(simd_sources ${sources})
  list(FILTER simd_sources INCLUDE REGEX "\\.simd\\.cpp$")
  list(FILTER sources EXCLUDE REGEX "\\.simd\\.cpp$")
  add_library(${name} ${sources})
  if(simd_sources)
    recon_add_simd_sources(${name} ${simd_sources})
  endif()
  target_compile_definitions(${name} PRIVATE ${RECON_SET_DEFINITIONS})
  # The same squared distances as in the kernels, whatever instructions the whole build may use.
  foreach(source IN LISTS sources)
    if(source MATCHES "/neighbourhood/")
      set_source_files_properties(${source} PROPERTIES COMPILE_OPTIONS -ffp-contract=off)
    endif()
  endforeach()
  string(REPLACE recon_ "" short ${name})
  add_library(recon::${short} ALIAS ${name})
  target_compile_features(${name} PUBLIC cxx_std_20)
  target_include_directories(${name}
    PUBLIC $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>
    PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/src)
  recon_set_compile_options(${name})
  set_target_properties(${name} PROPERTIES VERSION ${PROJECT_VERSION}
    SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  # A shared library shows what is recon's: not the packages behind its compiled code.
  if(BUILD_SHARED_LIBS AND RECON_LINKER_KNOWS_VERSION_SCRIPTS AND NOT RECON_SANITIZE)
    target_link_options(${name} PRIVATE -Wl,--version-script=${RECON_EXPORTED_SYMBOLS})
    set_target_properties(${name} PROPERTIES LINK_DEPENDS ${RECON_EXPORTED_SYMBOLS})
  endif()
  install(TARGETS ${name} EXPORT reconTargets
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT libraries NAMELINK_COMPONENT development
    RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT libraries)
endfunction()

# Headers, exported targets and the files that find_package(recon CONFIG) reads.
function(recon_install_packages)
  include(CMakePackageConfigHelpers)
  set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/recon)
  set(without)
  if(NOT RECON_HAS_PETSC)
    set(without PATTERN petsc EXCLUDE PATTERN ranks EXCLUDE)
  endif()
  if(NOT RECON_HAS_CUDA)
    list(APPEND without PATTERN cuda EXCLUDE)
  endif()
  install(DIRECTORY include/recon DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development ${without})
  install(EXPORT reconTargets NAMESPACE recon:: DESTINATION ${package_dir} COMPONENT development)
  configure_package_config_file(cmake/reconConfig.cmake.in ${PROJECT_BINARY_DIR}/reconConfig.cmake
    INSTALL_DESTINATION ${package_dir})
  write_basic_package_version_file(${PROJECT_BINARY_DIR}/reconConfigVersion.cmake
    COMPATIBILITY SameMinorVersion)
  install(FILES ${PROJECT_BINARY_DIR}/reconConfig.cmake ${PROJECT_BINARY_DIR}/reconConfigVersion.cmake
    DESTINATION ${package_dir} COMPONENT development)
  if(RECON_IO_HDF5)
    install(FILES cmake/ReconHdf5.cmake DESTINATION ${package_dir} COMPONENT development)
  endif()

  if(RECON_HAS_PETSC)
    install(FILES cmake/ReconPetsc.cmake DESTINATION ${package_dir} COMPONENT development)
  endif()

  # The same for pkg-config: recon, recon-io, recon-mpm, recon-c. (For recon::petsc there is none: MPI has its own ways.)
  set(openmp)
  if(RECON_HAS_OPENMP AND RECON_STATIC)
    set(openmp ${OpenMP_CXX_FLAGS})
  endif()
  recon_install_pkg_config(recon recon "eigen3 >= 3.4" "" "${openmp}")
  if(RECON_HAS_IO)
    # Debian's `hdf5` is the one of the variants that was chosen last: the name of the variant that recon was built with.
    set(hdf5 hdf5)
    if(RECON_HDF5_LIBRARY MATCHES "/hdf5/(serial|openmpi|mpich)/")
      set(hdf5 hdf5-${CMAKE_MATCH_1})
    endif()
    set(io_needs zlib)
    if(RECON_IO_HDF5)
      string(APPEND io_needs ", ${hdf5}")
    endif()
    recon_install_pkg_config(recon-io recon_io "recon = ${PROJECT_VERSION}" "${io_needs}" "")
  endif()
  if(RECON_HAS_MPM)
    recon_install_pkg_config(recon-mpm recon_mpm "recon-io = ${PROJECT_VERSION}" "muparser, ${hdf5}" "")
  endif()
  if(RECON_HAS_C)
    recon_install_pkg_config(recon-c recon_c "" "recon-mpm = ${PROJECT_VERSION}" -lstdc++)
  endif()
endfunction()

# recon_install_pkg_config(name library requires requires_private libs_private)
function(recon_install_pkg_config name library requires requires_private libs_private)
  set(RECON_PC_NAME ${name})
  set(RECON_PC_LIBRARY ${library})
  set(RECON_PC_DESCRIPTION ${PROJECT_DESCRIPTION})
  set(RECON_PC_REQUIRES ${requires})
  set(RECON_PC_REQUIRES_PRIVATE ${requires_private})
  set(RECON_PC_LIBS_PRIVATE ${libs_private})
  # From the folder of the file up to the prefix, so that an installation can be moved.
  file(RELATIVE_PATH RECON_PC_PREFIX /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
  string(REGEX REPLACE "/$" "" RECON_PC_PREFIX "${RECON_PC_PREFIX}")
  configure_file(cmake/recon.pc.in ${PROJECT_BINARY_DIR}/${name}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)
endfunction()
