// Fields into files: CSV for tables, VTK XML for pictures in ParaView and VisIt.
//
//   .csv   write_csv   points and their fields as delimited text
//   .vti   write_vti   fields at the nodes of a structured grid (VTK ImageData)
//   .vtp   write_vtp   fields at scattered points (VTK PolyData, one vertex per point)
//   .pvd   write_pvd   a series of such files with their times (ParaView collection)
//   .pvti  write_pvti  a grid whose nodes are in several .vti files (write_vti_piece)
//   .pvtp  write_pvtp  points that are in several .vtp files
//
// write() chooses by the extension. All of them write the whole file or none of it
// (atomic_file.hpp).
//
// CSV. One header line: x, y, z (as many as there are dimensions), then the fields under their
// own names; a field of several components becomes name_x, name_y, name_z where it has as many
// components as there are dimensions, else name_0, name_1, ... Numbers have the fewest digits
// that read back to the same bits, NaN is written as nan. Names are quoted where they hold a
// delimiter, a quote, a blank at an end, or could be taken for a number or a comment.
// read_particles() reads the file back.
//
// VTK. Little-endian on any machine, binary in base64 within the XML, 64-bit headers, no
// compression; the size is 4/3 of that of the numbers. (Raw bytes behind the XML would be smaller,
// and are what ParaView on Debian 12 fails to read since expat was updated.) Step and time of the FieldSet become field
// data under the names "step" and "TimeValue" (the one that ParaView takes for the time). Vectors
// are written with three components x, y, z and tensors with nine, xx, xy, ..., zz, whatever the
// dimension, because arrows, warps and stream lines take nothing else. FieldKind says which fields
// are vectors and tensors; components that the data lack are 0. Missing axes of a 1-D or 2-D grid
// are written as one node, those of a cloud as zero. The writer is recon's own because the only
// packaged one is VTK itself: 257 packages and 0.8 GB on Debian 12 for 200 lines.
//
// Wrong input throws InvalidArgument: fields that are not one value per point, a coordinate that is
// not finite, two columns of one name. Trouble with the file throws FileError.
#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include "recon/fields/field_set.hpp"
#include "recon/io/error.hpp"
#include "recon/points/structured_grid.hpp"
#include "recon/points/view.hpp"

namespace recon {

void write_csv(const std::filesystem::path& path, const PointsView<double>& points,
               const FieldSet& fields);
void write_vti(const std::filesystem::path& path, const StructuredGrid<double>& grid,
               const FieldSet& fields);
void write_vtp(const std::filesystem::path& path, const PointsView<double>& points,
               const FieldSet& fields);

// One file of a series: its name as the .pvd has it (relative to the folder of the
// .pvd), and its time.
struct TimedFile {
  double time = 0;
  std::filesystem::path file;
};
// Throws InvalidArgument for a time that is not finite, and for a name that is not UTF-8.
void write_pvd(const std::filesystem::path& path, const std::vector<TimedFile>& files);

// The nodes first[d], ..., first[d] + counts[d] - 1 of a grid along each axis. Pieces beside each
// other share the nodes between them, as their cells need them.
struct GridPiece {
  std::array<std::size_t, max_dimension> first{}, counts{1, 1, 1};
  std::size_t size() const { return counts[0] * counts[1] * counts[2]; }
};
// The fields have a value for each node of the piece, the first axis fastest. Throws
// InvalidArgument for a piece without nodes or with nodes that the grid does not have.
void write_vti_piece(const std::filesystem::path& path, const StructuredGrid<double>& grid,
                     const GridPiece& piece, const FieldSet& fields);
// The file that names the pieces, by their names relative to its folder; of `fields` it takes
// names, components, types, step and time. It must be written last: ParaView then reads them all.
struct GridPieceFile {
  GridPiece piece;
  std::filesystem::path file;
};
void write_pvti(const std::filesystem::path& path, const StructuredGrid<double>& grid,
                const std::vector<GridPieceFile>& pieces, const FieldSet& fields);

// The same for points: the file that names .vtp files whose fields are those of `fields`, and whose
// points have this dimension.
void write_pvtp(const std::filesystem::path& path, int dimension,
                const std::vector<std::filesystem::path>& pieces, const FieldSet& fields);

// Chooses by the extension: .csv or .vti for a grid, .csv or .vtp for points. FileError for others.
void write(const std::filesystem::path& path, const StructuredGrid<double>& grid,
           const FieldSet& fields);
void write(const std::filesystem::path& path, const PointsView<double>& points,
           const FieldSet& fields);

// Throws the FileError of write() for an extension that it does not know, so that a program can
// find out before a long computation. grid: whether a grid or points will be written.
void require_writable_extension(const std::filesystem::path& path, bool grid);

}  // namespace recon
