// Frames of particles as an H5MD file (nongnu.org/h5md, version 1.1):
//
//   /h5md                       version, author, creator
//   /particles/all/box          dimension, boundary, edges and offset (where there is a box)
//   /particles/all/position     value[frame][particle][axis], step[frame], time[frame]
//   /particles/all/<array>      value, and the same step and time
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "read_array.hpp"
#include "recon/fields/particle_table.hpp"

namespace recon::detail {

struct H5mdFrame {
  std::int64_t step = 0;
  std::optional<double> time;
  std::optional<SimulationCell> cell;
  std::array<bool, max_dimension> periodic{};
  std::vector<ReadArray> arrays;  // the first one is position, of three components
};

// The bytes of the file. All frames have the same arrays, for as many particles, and all or none a
// cell; times are written where all have one. Throws FileError, which names `path`, where recon was
// built without HDF5 or the library fails.
std::string h5md_image(const std::filesystem::path& path, const std::vector<H5mdFrame>& frames);

}  // namespace recon::detail
