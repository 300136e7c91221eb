// Tables of particles into files that other programs read.
//
//   .csv                 delimited text with a line of names; one frame
//   .vtp                 VTK PolyData, a vertex for each particle; one frame
//   .xyz, .extxyz        extended XYZ: Lattice, pbc, Properties, Time, Step; frames
//   .dump, .lammpstrj    LAMMPS text dump; frames
//   .h5, .h5md           H5MD (needs a recon that was built with HDF5); frames
//
// Columns go by name. Coordinates are those of the table (all of them, also a constant one);
// columns such as vx, vy, vz and s_xx, ..., s_zz become one array (velocity, s) where a format has
// arrays, and id, type, mol, ix, iy, iz stay whole numbers. What a reader gives, a writer of the
// same format writes so that it reads back to the same numbers: doubles to the last bit, boxes,
// periods, step and time as far as the format has a place for them. CSV has none for box, step and
// time, VTP none for the box, H5MD none for texts. Texts are kept in CSV, XYZ and dumps, with
// blanks as '_' in the latter two, and so are names. notes() says what was left out or renamed.
//
// ```cpp
//   recon::ParticleWriter out("chute.xyz");
//   recon::FrameReader frames("chute.dump.gz");
//   while (std::optional<recon::ParticleTable> table = frames.next()) out.add(*table);
//   out.commit();
// ```
//
// Nothing stands in the file's place before commit(), and then all of it. XYZ and dumps are written
// as frames come; of H5MD all frames are kept in memory, twice at the end.
//
// Wrong input throws InvalidArgument: a table without coordinates, a second frame where a format
// has one, and in H5MD a frame with other particles or columns than the first. Trouble with the
// file throws FileError.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "recon/fields/particle_table.hpp"
#include "recon/io/error.hpp"

namespace recon {

enum class ParticleFormat { csv, vtp, xyz, lammps_dump, h5md };

// The names csv, vtp, xyz, dump, h5md in this order.
const std::vector<std::string>& particle_format_names();
// Throws InvalidArgument for another name, with the nearest ones.
ParticleFormat particle_format(std::string_view name);
// By the extension. Throws FileError for one that is not known.
ParticleFormat particle_format_of(const std::filesystem::path& path);
// Whether a file of this format may have several frames.
bool has_frames(ParticleFormat format);

class ParticleWriter {
 public:
  // Throws FileError where no such file can be written.
  explicit ParticleWriter(const std::filesystem::path& path);
  ParticleWriter(const std::filesystem::path& path, ParticleFormat format);
  ~ParticleWriter();
  ParticleWriter(ParticleWriter&&) noexcept;
  ParticleWriter& operator=(ParticleWriter&&) noexcept;

  // Adds a frame. Without a step of its own its number, counted from 0, is the step.
  void add(const ParticleTable& table);
  // Puts the file in its place. Without a frame it throws InvalidArgument.
  void commit();

  // What was left out or renamed, in words; each once.
  const std::vector<std::string>& notes() const;

  class Format;  // a format's own part

 private:
  std::unique_ptr<Format> format_;
  bool several_ = false;
};

// One frame.
void write_particles(const std::filesystem::path& path, const ParticleTable& table);

}  // namespace recon
