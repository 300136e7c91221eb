# How a room becomes part of a library, and how the libraries are installed.

# Warnings and sanitizers, for everything that is built here and nothing that consumes it.
function(recon_set_compile_options target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
    $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>  # g++ 12 sees overlap in text + std::string where none is
    $<$<BOOL:${RECON_WARNINGS_AS_ERRORS}>:-Werror>)
  if(RECON_SANITIZE)
    target_compile_options(${target} PRIVATE -fsanitize=${RECON_SANITIZE} -fno-sanitize-recover=all
      -fno-omit-frame-pointer)
    target_link_options(${target} PRIVATE -fsanitize=${RECON_SANITIZE})
  endif()
endfunction()

# recon_add_library(name ROOMS room...): the sources are those in src/<room>/.
function(recon_add_library name)
  cmake_parse_arguments(arg "" "" "ROOMS" ${ARGN})
  set(sources)
  foreach(room IN LISTS arg_ROOMS)
    file(GLOB room_sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/src/${room}/*.cpp)
    list(APPEND sources ${room_sources})
  endforeach()
  add_library(${name} ${sources})
  string(REPLACE recon_ "" short ${name})
  add_library(recon::${short} ALIAS ${name})
  target_compile_features(${name} PUBLIC cxx_std_20)
  target_include_directories(${name}
    PUBLIC $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>
    PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/src)
  recon_set_compile_options(${name})
  set_target_properties(${name} PROPERTIES VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR})
  install(TARGETS ${name} EXPORT reconTargets
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
    RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endfunction()

# Headers, exported targets and the files that find_package(recon CONFIG) reads.
function(recon_install_packages)
  include(CMakePackageConfigHelpers)
  set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/recon)
  install(DIRECTORY include/recon DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  install(EXPORT reconTargets NAMESPACE recon:: DESTINATION ${package_dir})
  configure_package_config_file(cmake/reconConfig.cmake.in ${PROJECT_BINARY_DIR}/reconConfig.cmake
    INSTALL_DESTINATION ${package_dir})
  write_basic_package_version_file(${PROJECT_BINARY_DIR}/reconConfigVersion.cmake
    COMPATIBILITY SameMinorVersion)
  install(FILES ${PROJECT_BINARY_DIR}/reconConfig.cmake ${PROJECT_BINARY_DIR}/reconConfigVersion.cmake
    DESTINATION ${package_dir})
endfunction()
