# The target recon::petsc_engine, PETSc (3.18 or newer, of real doubles) and MPI, where both are found; else
# RECON_PETSC_LACKS says what is missing. Read by recon's build and by the package that it installs.
set(RECON_PETSC_LACKS)
find_package(PkgConfig QUIET)
if(PkgConfig_FOUND)
  pkg_check_modules(RECON_PETSC QUIET PETSc>=3.18)
endif()
find_package(MPI QUIET COMPONENTS CXX)
if(NOT PkgConfig_FOUND)
  set(RECON_PETSC_LACKS "pkg-config was not found, which says where PETSc is")
elseif(NOT RECON_PETSC_FOUND)
  set(RECON_PETSC_LACKS "PETSc 3.18 or newer was not found (Debian: petsc-dev)")
elseif(NOT MPI_CXX_FOUND)
  set(RECON_PETSC_LACKS "MPI was not found (Debian: libopenmpi-dev)")
elseif(NOT TARGET recon::petsc_engine)
  # Of PETSc's flags no others: those of the compiler are the user's own.
  add_library(recon::petsc_engine INTERFACE IMPORTED)
  set_target_properties(recon::petsc_engine PROPERTIES
    INTERFACE_INCLUDE_DIRECTORIES "${RECON_PETSC_INCLUDE_DIRS}"
    INTERFACE_LINK_LIBRARIES "${RECON_PETSC_LINK_LIBRARIES};MPI::MPI_CXX"
    INTERFACE_COMPILE_DEFINITIONS "OMPI_SKIP_MPICXX;MPICH_SKIP_MPICXX")
endif()
