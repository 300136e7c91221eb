// Particles from a file.
//
// Formats are told apart by what a file contains, not by its name, and gzip is undone on the way:
//
//   LAMMPS text dump    One or more frames; columns of any kind in any order; boundary flags give
//                       the periodic axes. Boxes are orthogonal or triclinic, restricted (tilts xy,
//                       xz, yz) or general (abc origin): see ParticleTable::set_cell(). Scaled
//                       coordinates xs, ys, zs become columns x, y, z, and xsu, ysu, zsu become
//                       xu, yu, zu (x = origin + xs a + ys b + zs c with the edges of the box),
//                       unless those are there already.
//   delimited text      Commas, semicolons, tabs or blanks, with a line of column names before the
//                       numbers, which may start with '#' or '%', or the names from the options.
//                       Other lines that start with '#' or '%', and blank lines, are skipped. Names
//                       and cells may stand in double quotes ("" inside for one quote). A unit
//                       stays part of the name: "x [m]". A first row without any number, before one
//                       that has some, holds units: it is no particle, and a remark says so. An
//                       empty name becomes column_<number>. The decimal sign is the point, whatever
//                       the locale.
//
//   XYZ                 Plain, or extended by key=value pairs on the comment line: Properties names
//                       the columns, Lattice is the box (periodic unless pbc says otherwise; Origin
//                       may move its corner), and Time and Step (or Timestep) are known; other keys
//                       are passed over. Plain lines are element, x, y, z and further numbers,
//                       column_5, ... One or more frames.
//   VTK                 Points and their data of polygonal data, unstructured, structured and image
//                       grids (nodes of the latter become points): legacy files of any version in
//                       text or binary, and XML files (.vtp, .vtu, .vts, .vti) with data in text or
//                       base64 or appended, plain or compressed by zlib; .pvtp and .pvtu, with the
//                       files that they name. Cells and their data are passed over. The time is TimeValue (or TIME), the step `step` (or CYCLE).
//   HDF5                H5MD (positions and every other element of a group of particles that has a
//                       value for each of them; box and boundary) and openPMD (the records of a
//                       species at each iteration, in units of the SI: positions are position +
//                       positionOffset). Needs a recon that was built with HDF5.
//
// The two binary formats have arrays with several components. They become columns by these rules:
// position gives x, y, z; velocity gives vx, vy, vz and force fx, fy, fz; two or three components
// of any other array end in _x, _y, _z, the nine of a tensor in _xx, _xy, ..., others in _0, _1,
// ... (or in the names that VTK knows them by). They are read as a whole: a VTK file, or a frame of
// HDF5, takes memory for its bytes and for its numbers.
//
// Rows keep the order of the file. Columns are checked when they are used (ParticleTable): text,
// empty cells, numbers too large for double and names that several columns have are no error until
// a column is asked for. Names that are not UTF-8 are read as Latin-1 (Windows-1252) and converted.
//
// What is wrong with a file throws FileError with the line: a broken or missing line, a wrong
// number of cells, a damaged or cut gzip stream, bytes behind the gzip data, an unknown format. Of
// what is binary the message names the array or data set instead.
//
// A file may end within a frame, because a run was stopped or a copy was broken off. The frames
// before that one are listed and read, with a remark; asking for the cut one is an error, and so is
// a file without a whole frame. Where the last line is complete but for its line break, its last
// number may lack digits: a remark says so.
//
// All frames, with the memory of one:
//
// ```cpp
//   recon::FrameReader frames("chute.dump.gz");
//   while (std::optional<recon::ParticleTable> table = frames.next()) use(*table);
//   if (!frames.cut().empty()) std::cerr << frames.cut() << std::endl;
// ```
//
// Cost: one pass over the file to find the frames, and one over the frame asked for; memory for
// that frame only. A frame counted from the front is read without looking at what comes after it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "recon/fields/particle_table.hpp"
#include "recon/io/error.hpp"

namespace recon {

struct FrameInfo {
  std::optional<std::int64_t> step;  // where the file says it
  std::optional<double> time;        // where the file says it
  std::size_t particles = 0;
  std::vector<std::string> columns;  // names, as in the file
  std::size_t line = 0;              // where the frame begins; 0 in VTK and HDF5
  std::string units;                 // of LAMMPS: "lj", "si", ..., where the file says it
};

struct ReadOptions {
  // Which frame is read. Give one of these: its number, counted from 0, or from the end (-1 is the
  // last); its step; its time (to 1e-9 of it). FrameReader takes all frames and ignores them.
  int frame = -1;
  std::optional<std::int64_t> step = {};
  std::optional<double> time = {};
  // Names of all columns, which replace those of the file; it then needs none.
  std::vector<std::string> columns = {};
  // The number of lines to skip at the beginning of the file.
  std::size_t skip_rows = 0;
  // What marks a cell without a value: see ParticleTable::declare_missing(). Particles without a
  // value in a column that is used are left out by ParticleTable::leave_out_missing().
  std::vector<std::string> missing = {};
  // In HDF5: the name of the group of particles (H5MD) or of their species (openPMD). It may be
  // left out where there is only one, and must be for other formats.
  std::string group = {};
  // Only one of several parts of the particles, which together are all: `part` of `parts`, counted
  // from 0, in turns of 256 rows. The text of other rows is passed over unread; a VTK file, or a
  // frame of HDF5, is read as a whole before the others are dropped. FrameInfo and
  // list_frames() are of all particles.
  int part = 0, parts = 1;

  // Whether a row of the file belongs to the part.
  bool takes(std::size_t row) const {
    return row / 256 % static_cast<std::size_t>(parts) == static_cast<std::size_t>(part);
  }
};

// Lists all complete frames in the order of the file, whatever frame the options ask for. Delimited
// text is one frame.
std::vector<FrameInfo> list_frames(const std::filesystem::path& path,
                                   const ReadOptions& options = {});

// Reads the particles of one frame. Throws FileError for a frame that the file does not have,
// telling which it has, and for a file that is not there, naming files of that directory with
// a similar name. Throws InvalidArgument where more than one of frame (other than -1), step
// and time is given.
ParticleTable read_particles(const std::filesystem::path& path, const ReadOptions& options = {});

// Both also read bytes in memory, as a file has them (gzip too); messages call them `name`.
std::vector<FrameInfo> list_frames_of(std::string_view bytes, const ReadOptions& options = {},
                                      const std::string& name = "memory");
ParticleTable read_particles_of(std::string_view bytes, const ReadOptions& options = {},
                                const std::string& name = "memory");

// Walks through the frames of a file in one pass, with the memory of one frame.
class FrameReader {
 public:
  // Throws FileError for a file that is not there or of no known format.
  explicit FrameReader(const std::filesystem::path& path, const ReadOptions& options = {});
  // The frames of bytes in memory, which must outlive this object; messages call them `name`.
  explicit FrameReader(std::string_view bytes, const ReadOptions& options, const std::string& name);
  ~FrameReader();
  FrameReader(FrameReader&&) noexcept;
  FrameReader& operator=(FrameReader&&) noexcept;

  // The next frame as read_particles() gives it; empty after the last complete one. Throws
  // FileError for what is wrong within a frame, and where not even the first one is complete.
  std::optional<ParticleTable> next();
  // Skips a frame without reading its particles. Returns what it is, or nothing at the end.
  std::optional<FrameInfo> skip();

  // The number of the frame that the next call gives, counted from 0.
  std::size_t position() const;
  // After the last complete frame: where and why the file ends within a frame, if it
  // does; else empty.
  const std::string& cut() const;
  // The part of the file's bytes that has been read, from 0 to 1.
  double progress() const;

 private:
  struct State;
  static std::vector<FrameInfo> list(State& state);
  friend std::vector<FrameInfo> list_frames(const std::filesystem::path&, const ReadOptions&);
  friend ParticleTable read_particles(const std::filesystem::path&, const ReadOptions&);
  friend std::vector<FrameInfo> list_frames_of(std::string_view, const ReadOptions&,
                                               const std::string&);
  friend ParticleTable read_particles_of(std::string_view, const ReadOptions&, const std::string&);
  std::unique_ptr<State> state_;
};

}  // namespace recon
