// The formats that read.cpp chooses from. Each reads from a file that stands at its beginning.
#pragma once

#include <vector>

#include "recon/io/read.hpp"
#include "text_file.hpp"

namespace recon::detail {

std::vector<FrameInfo> list_lammps_frames(TextFile& file);
ParticleTable read_lammps_frame(TextFile& file, int frame);

FrameInfo describe_delimited(TextFile& file);
ParticleTable read_delimited(TextFile& file);

// Throws FileError: the file has `frames` frames, not the one asked for.
[[noreturn]] void fail_unknown_frame(const TextFile& file, int frame, std::size_t frames);

}  // namespace recon::detail
