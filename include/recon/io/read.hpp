// Particles from a file.
//
// Formats are told apart by what a file contains, not by its name, and gzip is undone on the way:
//
//   LAMMPS text dump    one or more frames; orthogonal boxes (a triclinic one is refused); columns
//   of
//                       any kind in any order; boundary flags give the periodic axes. Scaled
//                       coordinates xs, ys, zs become columns x, y, z, and xsu, ysu, zsu become
//                       xu, yu, zu (x = lower + xs (upper - lower)), unless those are there
//                       already.
//   delimited text      commas, semicolons, tabs or blanks, with a line of column names before the
//                       numbers, which may start with '#'. Other lines that start with '#', and
//                       blank lines, are skipped; names and cells may stand in double quotes (""
//                       inside for one quote). A unit stays part of the name: "x [m]". An empty
//                       name becomes column_<number>. Decimal sign is the point, whatever the
//                       locale.
//
// Rows keep the order of the file. A column whose first cell that is not empty is no number holds
// text: it is left out and listed in text_columns() and remarks. Columns of coordinates never do.
//
// What is wrong with a file throws FileError with the line: a broken or missing line, a wrong
// number of cells, text among numbers, a number too large for double, a damaged or cut gzip stream,
// an unknown format. Cells that are empty or nan are kept as NaN, which the table reports when the
// column is used.
//
// Cost: one pass over the file to find the frames, and one over the frame asked for; memory for
// that frame only. A frame counted from the front is read without looking at what comes after it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "recon/fields/particle_table.hpp"
#include "recon/io/error.hpp"

namespace recon {

struct FrameInfo {
  std::optional<std::int64_t> step;  // none in delimited text
  std::optional<double> time;        // where the file says it
  std::size_t particles = 0;
  std::vector<std::string> columns;  // names, as in the file
  std::size_t line = 0;              // where the frame begins
};

struct ReadOptions {
  int frame = -1;  // counted from 0; negative from the end: -1 is the last
};

// All frames of a file, in the order of the file. Delimited text is one frame.
std::vector<FrameInfo> list_frames(const std::filesystem::path& path);

// The particles of one frame. Throws FileError for a frame that the file does not have, telling how
// many there are, and for a file that is not there, naming files of that directory with a like
// name.
ParticleTable read_particles(const std::filesystem::path& path, const ReadOptions& options = {});

}  // namespace recon
