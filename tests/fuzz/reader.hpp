// What every reader of particles must do with any bytes: frames and tables, or an error that
// says what is wrong.
#pragma once

#include <cstdlib>
#include <string_view>

#include "recon/core/error.hpp"
#include "recon/io/read.hpp"

namespace recon::fuzz {

inline void read(std::string_view bytes) {
  if (bytes.starts_with("\x89HDF"))
    return;  // the HDF5 library is not ours, and falls over such bytes
  try {
    list_frames_of(bytes);
  } catch (const FileError&) {
  }
  for (const int frame : {-1, 0, 1}) try {
      const ParticleTable table =
          read_particles_of(bytes, {.frame = frame, .step = {}, .time = {}});
      for (int dimension = 1; dimension <= 3; ++dimension) try {
          const auto points = table.positions(dimension);
          if (points.size() != table.size()) std::abort();
        } catch (const std::invalid_argument&) {  // no such columns
        } catch (const FileError&) {
        }
    } catch (const FileError&) {
    }
}

}  // namespace recon::fuzz
