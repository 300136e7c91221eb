# recon::cuda, reconstruction in the memory of a GPU, and recon::gpu, runs there: libraries compiled by nvcc 12 or newer. The host's part
# of them is compiled by the same C++ compiler as all else. CMAKE_CUDA_ARCHITECTURES says for which GPUs (90 by default).
include(CheckLanguage)
check_language(CUDA)
if(NOT CMAKE_CUDA_COMPILER)
  message(FATAL_ERROR "recon: no nvcc was found; -DCMAKE_CUDA_COMPILER says where it is, -DRECON_CUDA=OFF builds without it")
endif()
if(NOT DEFINED CMAKE_CUDA_ARCHITECTURES)
  set(CMAKE_CUDA_ARCHITECTURES 90)
endif()
enable_language(CUDA)
# Older versions of CMake do not know that nvcc 12 has C++20.
foreach(kind STANDARD EXTENSION)
  if(NOT CMAKE_CUDA20_${kind}_COMPILE_OPTION)
    set(CMAKE_CUDA20_${kind}_COMPILE_OPTION "-std=c++20")
  endif()
endforeach()
find_package(CUDAToolkit 12 REQUIRED)
if(CMAKE_CUDA_COMPILER_VERSION VERSION_LESS 12)
  message(FATAL_ERROR "recon: nvcc ${CMAKE_CUDA_COMPILER_VERSION} was found; recon::cuda needs 12 or newer")
endif()

# recon_add_cuda_library(name room): the static library `name`, exported as recon::<room>, of the room's .cu files.
function(recon_add_cuda_library name room)
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/${room}/*.cu)
  add_library(${name} STATIC ${sources})
  add_library(recon::${room} ALIAS ${name})
  set_target_properties(${name} PROPERTIES EXPORT_NAME ${room} CUDA_STANDARD 20 CUDA_RUNTIME_LIBRARY None)
  target_compile_features(${name} PUBLIC cxx_std_20)
  target_compile_options(${name} PRIVATE "$<$<COMPILE_LANGUAGE:CUDA>:--expt-relaxed-constexpr;-Werror;all-warnings>")
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/src)
  install(TARGETS ${name} EXPORT reconTargets
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)
endfunction()
recon_add_cuda_library(recon_cuda cuda)
target_link_libraries(recon_cuda PUBLIC recon CUDA::cudart_static)

# recon-gpu, which checks and times it (bench/run_gpu): one file that needs nothing but a driver.
add_executable(recon_gpu EXCLUDE_FROM_ALL ${PROJECT_SOURCE_DIR}/bench/gpu/recon_gpu.cpp)
set_target_properties(recon_gpu PROPERTIES OUTPUT_NAME recon-gpu)
target_include_directories(recon_gpu PRIVATE ${PROJECT_SOURCE_DIR}/bench)
target_link_libraries(recon_gpu PRIVATE recon_cuda -static-libstdc++ -static-libgcc)
recon_set_compile_options(recon_gpu)
