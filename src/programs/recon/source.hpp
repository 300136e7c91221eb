// Where particles come from: files, and pipes, which cannot be read twice and are kept as bytes.
//
// "-" is the standard input; a named pipe or what a shell makes of <(command) is told by its kind.
#pragma once

#include <string>
#include <vector>

#include "recon/io/read.hpp"

namespace recon::program {

// These are list_frames(), read_particles() and FrameReader for either. They throw as these do.
std::vector<FrameInfo> list_source(const std::string& file, const ReadOptions& options);
ParticleTable read_source(const std::string& file, const ReadOptions& options);
FrameReader open_source(const std::string& file, const ReadOptions& options);

}  // namespace recon::program
