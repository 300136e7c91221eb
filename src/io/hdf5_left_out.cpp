// In place of hdf5.cpp and hdf5_particles.cpp where recon is built without HDF5.
#include "formats.hpp"
#include "h5md_file.hpp"

namespace recon::detail {

namespace {
constexpr const char* left_out = "is HDF5, and this recon was built without (Debian: libhdf5-dev)";
}  // namespace

std::unique_ptr<FrameSource> open_hdf5_particles(const std::filesystem::path& path, std::string,
                                                 const ReadOptions&) {
  throw FileError(path, 0, left_out);
}

std::string h5md_image(const std::filesystem::path& path, const std::vector<H5mdFrame>&) {
  throw FileError(path, 0, left_out);
}

}  // namespace recon::detail
