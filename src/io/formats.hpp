// The formats that read.cpp chooses from. Each reads from a file that stands at its beginning.
#pragma once

#include <functional>
#include <memory>

#include "read_array.hpp"
#include "recon/io/read.hpp"
#include "text_file.hpp"

namespace recon::detail {

// A file as a series of frames: next(), and then either skip() or read().
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  // Whether there is another frame.
  virtual bool next() = 0;
  // About the frame that next() found. In delimited text skip() and read() count the particles.
  virtual const FrameInfo& info() const = 0;
  virtual void skip() = 0;
  virtual ParticleTable read() = 0;
  // Goes back: the next frame is this one, which next() found before.
  virtual void go_to(std::size_t frame) = 0;
  // Whether a file of this format may have several frames.
  virtual bool is_series() const = 0;
  // Whether what next(), skip() or read() stumbled over is the end of a file that may be cut off.
  virtual bool ended() const { return false; }
  // Whether the file ends without a line break behind the last line that was read.
  virtual bool ends_open() const { return false; }
  // The part of the file's bytes that has been read, from 0 to 1.
  virtual double progress() const { return 1; }
};

// Of a format that is lines of text.
class TextFrames : public FrameSource {
 public:
  explicit TextFrames(TextFile& file) : file_(&file) {}
  bool next() final;
  void go_to(std::size_t frame) final;
  bool ended() const final { return file_->ended(); }
  bool ends_open() const final { return !file_->line_is_closed(); }
  double progress() const final { return file_->progress(); }

 protected:
  TextFile& file() const { return *file_; }
  // How many frames were found before.
  std::size_t found() const { return begins_.size(); }
  // Reads the header of the next frame; false where there is none.
  virtual bool find() = 0;

 private:
  TextFile* file_;
  std::vector<TextFile::Mark> begins_;  // of the frames found
};

// Converts names to UTF-8, with a remark where they were not.
std::vector<std::string> to_utf8(const std::vector<std::string>& names,
                                 std::vector<std::string>& remarks);

// Whether the edges of a cell lie along x, y and z.
bool is_orthogonal(const SimulationCell& cell);
// The box of a table from three edges: an orthogonal one where these lie along x, y, z.
void set_cell_or_box(ParticleTable& table, const SimulationCell& cell,
                     std::array<bool, max_dimension> periodic);

// Whether the file that stands at its beginning is XYZ: its first line is one number of particles.
bool is_xyz(TextFile& file);

// The frames of a file of each text format, which stands at its beginning; both arguments must outlive
// them. Delimited text is one frame.
std::unique_ptr<FrameSource> lammps_frames(TextFile& file, const ReadOptions& options);
std::unique_ptr<FrameSource> xyz_frames(TextFile& file, const ReadOptions& options);
std::unique_ptr<FrameSource> delimited_frame(TextFile& file, const ReadOptions& options);

// What a VTK file holds at points, as far as a table of particles has a place for it.
struct VtkPoints {
  std::vector<double> points;  // x, y, z of each
  std::vector<ReadArray> arrays;
  std::optional<std::int64_t> step;
  std::optional<double> time;
  std::vector<std::string> remarks;
};
// Both throw FileError for content that is broken or of a kind that is not read.
VtkPoints read_legacy_vtk(std::string_view bytes, const std::filesystem::path& path);
// `open` gives the bytes of other files, in which pieces may be; null: these are refused.
using OpenFile = std::function<std::string(const std::filesystem::path&)>;
VtkPoints read_xml_vtk(std::string_view bytes, const std::filesystem::path& path,
                       const OpenFile& open);

// What a table of particles makes of it: one frame.
std::unique_ptr<FrameSource> vtk_frame(VtkPoints read, const ReadOptions& options);

// Particles in an HDF5 file: H5MD, or as openPMD lays them out. `image` are the bytes of the file;
// if it is empty, the file is opened by its path. Throws FileError where recon was built
// without HDF5.
std::unique_ptr<FrameSource> open_hdf5_particles(const std::filesystem::path& path,
                                                 std::string image, const ReadOptions& options);

}  // namespace recon::detail
