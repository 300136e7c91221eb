// A list of files that belong together, one for each time: what ParaView opens as an animation.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "recon/io/error.hpp"

namespace recon {

struct SeriesEntry {
  double time;
  std::string file;  // as seen from the folder of the list
};

// A VTK collection (.pvd), in the order given. The whole file or none of it (atomic_file.hpp).
// Throws InvalidArgument for a time that is not finite; trouble with the file throws FileError.
void write_pvd(const std::filesystem::path& path, const std::vector<SeriesEntry>& entries);

}  // namespace recon
