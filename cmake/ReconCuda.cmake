# recon::cuda, reconstruction in the memory of a GPU: the library recon_cuda, compiled by nvcc 12 or newer. The host's part
# of it is compiled by the same C++ compiler as all else. CMAKE_CUDA_ARCHITECTURES says for which GPUs (90 by default).
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

file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/cuda/*.cu)
add_library(recon_cuda STATIC ${sources})
add_library(recon::cuda ALIAS recon_cuda)
set_target_properties(recon_cuda PROPERTIES EXPORT_NAME cuda CUDA_STANDARD 20 CUDA_RUNTIME_LIBRARY None)
target_compile_features(recon_cuda PUBLIC cxx_std_20)
target_compile_options(recon_cuda PRIVATE --expt-relaxed-constexpr -Werror all-warnings)
target_include_directories(recon_cuda PRIVATE ${PROJECT_SOURCE_DIR}/src)
target_link_libraries(recon_cuda PUBLIC recon CUDA::cudart_static)
install(TARGETS recon_cuda EXPORT reconTargets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)

# recon-gpu, which checks and times it (bench/run_gpu): one file that needs nothing but a driver.
add_executable(recon_gpu EXCLUDE_FROM_ALL ${PROJECT_SOURCE_DIR}/bench/gpu/recon_gpu.cpp)
set_target_properties(recon_gpu PROPERTIES OUTPUT_NAME recon-gpu)
target_include_directories(recon_gpu PRIVATE ${PROJECT_SOURCE_DIR}/bench)
target_link_libraries(recon_gpu PRIVATE recon_cuda -static-libstdc++ -static-libgcc)
recon_set_compile_options(recon_gpu)
