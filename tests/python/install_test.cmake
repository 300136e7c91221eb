# cmake -DPYTHON= -DSOURCE= -DSCRATCH= [-DRECON_BUILD= -DCONFIG=] -P install_test.cmake
#
# pip builds and installs the module into a fresh environment without a network, and a program there uses it. With
# RECON_BUILD the library of that build is installed and used; without it pip's build makes its own.
file(REMOVE_RECURSE ${SCRATCH})
file(MAKE_DIRECTORY ${SCRATCH})

function(run)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${SCRATCH} RESULT_VARIABLE result OUTPUT_VARIABLE output
    ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    string(REPLACE ";" " " command "${ARGN}")
    message(FATAL_ERROR "'${command}' ended with ${result}:\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

# scikit-build builds beside setup.py: in a copy of what it needs.
foreach(part pyproject.toml setup.py CMakeLists.txt LICENSE README.md cmake include src)
  file(COPY ${SOURCE}/${part} DESTINATION ${SCRATCH}/source)
endforeach()
run(${PYTHON} -m venv --system-site-packages ${SCRATCH}/environment)
set(environment_python ${SCRATCH}/environment/bin/python)

if(RECON_BUILD)  # whether it builds and works is asked, not how fast it is
  foreach(component libraries development)
    run(${CMAKE_COMMAND} --install ${RECON_BUILD} --config ${CONFIG} --prefix ${SCRATCH}/prefix --component ${component})
  endforeach()
  file(GLOB_RECURSE config ${SCRATCH}/prefix/reconConfig.cmake)
  get_filename_component(folder ${config} DIRECTORY)
  set(ENV{CMAKE_ARGS} "-Drecon_DIR=${folder} -DCMAKE_CXX_FLAGS_RELEASE=-O0")
endif()
unset(ENV{PYTHONPATH})
set(ENV{PIP_NO_INDEX} 1)
set(ENV{PIP_DISABLE_PIP_VERSION_CHECK} 1)
run(${environment_python} -m pip install --no-build-isolation --no-deps ${SCRATCH}/source)

file(WRITE ${SCRATCH}/use.py [=[
import numpy as np
import recon

x = np.random.default_rng(1).uniform(size=(500, 2))
fit = recon.reconstruct(x, x[:5], degree=1)
assert np.allclose(fit @ x, x[:5])
print(recon.__version__, recon.__file__)
]=])
run(${environment_python} ${SCRATCH}/use.py)
if(NOT output MATCHES "${SCRATCH}/environment")
  message(FATAL_ERROR "another recon was used: ${output}")
endif()
message(STATUS "${output}")
