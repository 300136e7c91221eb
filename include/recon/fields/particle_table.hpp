// Particles as a table: named columns of numbers, one row per particle, as a file or a code has
// them.
//
// A table also carries what is known about its particles as a whole: step and time, the simulation
// box, which axes are periodic, where the data come from, and the reader's remarks. Rows keep the
// order of the source; a row remembers its line there, so that a message can name it.
//
// Coordinates. Unless set_coordinates() names the columns, those of axis x are sought under the
// names x, X, xu, Points:0, Points_0 in this order, and likewise for y and z (xu is LAMMPS'
// unwrapped coordinate, Points:0 what ParaView writes). The dimension is the number of axes that
// have a column, but one that is the same for all of two or more particles counts as none, unless
// all are: particles in a plane y = 0.5 are 2-D in x and z. Whoever wants them 3-D says
// positions(3).
//
// NaN and infinity may stand in a table (an empty cell of a CSV file is NaN) but are never handed
// out: column(), field() and positions() throw InvalidArgument that names the column, the row, the
// particle's id where there is a column `id`, and the line. raw_column() gives the numbers as they
// are.
//
//   recon::ParticleTable grains = recon::read_particles("chute.dump.gz");
//   recon::PointsView<double> points = grains.positions();           // no copy
//   recon::NamedField velocity = grains.field("velocity", {"vx", "vy", "vz"});
//   recon::PeriodicDomain<double> domain = grains.domain();
//
// Units are those of the source. Views refer to the table: they stay valid while it lives, also
// when it is moved or columns are added, but not when it is copied from or assigned to.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "recon/fields/field_set.hpp"
#include "recon/points/domain.hpp"
#include "recon/points/view.hpp"

namespace recon {

// The axis (0, 1, 2 for x, y, z) along which a column of this name holds coordinates: x, X, xu, ...
std::optional<int> axis_of_coordinate(std::string_view name);

class ParticleTable {
 public:
  // --- columns ---------------------------------------------------------------------------------
  // Throws InvalidArgument for an empty name, a name used twice, a length unlike that of the
  // others.
  void add_column(std::string name, std::vector<double> values);

  std::size_t size() const { return columns_.empty() ? 0 : columns_.front().size(); }
  const std::vector<std::string>& names() const { return names_; }
  bool has(std::string_view name) const;

  // Values of one column, all finite. Throws InvalidArgument for an unknown name (with the nearest
  // valid ones), for a column of text, and for a value that is NaN or infinite. Cost O(size()).
  const std::vector<double>& column(std::string_view name) const;
  const std::vector<double>& raw_column(std::string_view name) const;

  // Leaves the rows out for which `kept` is false. Throws InvalidArgument unless it has one entry
  // per row.
  void keep_rows(const std::vector<bool>& kept);

  // Several columns as one field, point-major. The components are the columns in the order given.
  NamedField field(std::string name, const std::vector<std::string>& columns) const;

  // --- coordinates -----------------------------------------------------------------------------
  // The columns that hold the coordinates, 1 to 3 of them; checked when they are used.
  void set_coordinates(std::vector<std::string> columns);
  // The columns used in `dimension` dimensions (0: as detected); throws where there are fewer.
  std::vector<std::string> coordinates(int dimension = 0) const;
  // Those columns whether constant or not: set, or else sought.
  std::vector<std::string> all_coordinates() const;
  // Which of x, y and z (0, 1, 2) each column of coordinates(dimension) lies along: the axis that
  // its name tells, else that of its place; all by their places where two would be the same.
  std::vector<int> axes(int dimension = 0) const;
  // See the rule at the top. Throws InvalidArgument where no column x, y or z is found.
  int dimension() const;

  // Throws InvalidArgument for a coordinate that is NaN or infinite. dimension = 0: as detected.
  PointsView<double> positions(int dimension = 0) const;

  // --- the simulation box ----------------------------------------------------------------------
  // Of the source: axes x, y, z, of which the first `dimension` of `box` are known.
  void set_box(const Box<double>& box, std::array<bool, max_dimension> periodic);
  bool has_box() const { return box_.has_value(); }

  // Box and periodic axes in the axes of coordinates(dimension): where these are, say, x and z, the
  // box has these two.
  // Without a box of the source: the bounding box of the positions, periodic nowhere.
  Box<double> box(int dimension = 0) const;
  PeriodicDomain<double> domain(int dimension = 0) const;

  // --- where the data come from ----------------------------------------------------------------
  std::string source;                // "chute.dump.gz, frame 5, step 50000"
  std::optional<std::int64_t> step;  // number of the time step
  std::optional<double> time;        // in the units of the source
  std::string units;                 // name of the unit system (LAMMPS: "lj", "si", ...), or empty
  std::vector<std::string> remarks;  // what the reader left out or assumed, for the user to see

  // Lines of the source, one per row; empty where there are none.
  void set_lines(std::vector<std::size_t> lines);
  // A column that holds text, of which `example` on `line` is the first; kept by name only.
  void add_text_column(std::string name, std::string example, std::size_t line);
  std::vector<std::string> text_columns() const;

  // "row 17 (id 42, line 27)", rows counted from 0: for messages about a particle.
  std::string describe_row(std::size_t row) const;

 private:
  struct TextColumn {
    std::string name, example;
    std::size_t line;
  };
  std::size_t find(std::string_view name) const;  // names_.size() where there is none
  void require_finite(std::size_t column) const;
  std::vector<std::string> detected_coordinates() const;
  std::vector<std::string> varying_coordinates() const;
  std::vector<int> box_axes(int dimension) const;

  std::vector<std::string> names_;
  std::vector<std::vector<double>> columns_;
  std::vector<TextColumn> text_columns_;
  std::vector<std::string> coordinates_;
  std::optional<Box<double>> box_;
  std::array<bool, max_dimension> periodic_{};
  std::vector<std::size_t> lines_;
};

}  // namespace recon
