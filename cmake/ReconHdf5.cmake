# The target recon::hdf5, the C library of HDF5, where it is found; else RECON_HDF5_LIBRARY is false. Read by recon's build
# and by the package that it installs. Not find_package(HDF5): that wants a C compiler.
find_path(RECON_HDF5_INCLUDE_DIR hdf5.h PATH_SUFFIXES hdf5/serial)
find_library(RECON_HDF5_LIBRARY NAMES hdf5 hdf5_serial PATH_SUFFIXES hdf5/serial)
mark_as_advanced(RECON_HDF5_INCLUDE_DIR RECON_HDF5_LIBRARY)
if(RECON_HDF5_LIBRARY AND NOT TARGET recon::hdf5)
  add_library(recon::hdf5 UNKNOWN IMPORTED)
  set_target_properties(recon::hdf5 PROPERTIES IMPORTED_LOCATION ${RECON_HDF5_LIBRARY})
  if(RECON_HDF5_INCLUDE_DIR)
    set_target_properties(recon::hdf5 PROPERTIES INTERFACE_INCLUDE_DIRECTORIES ${RECON_HDF5_INCLUDE_DIR})
  endif()
endif()
