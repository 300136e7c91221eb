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
// Columns are typed when they are used. A file may hold labels, words among numbers, empty cells or
// a name twice: as long as nobody asks for such a column, that is no error. column(), field() and
// positions() hand out finite numbers only and else throw InvalidArgument that names the column, the
// row, the particle's id where there is a column `id`, the line and the source, or the columns that
// share the name. raw_column() gives the numbers as they are, with NaN where a cell holds none.
//
// Missing values. What stands for "no value" in a file (NA, -9999) is declared with
// declare_missing(); leave_out_missing() then leaves out the particles that have no value in the
// columns that are used.
//
// ```cpp
//   recon::ParticleTable grains = recon::read_particles("chute.dump.gz");
//   recon::PointsView<double> points = grains.positions();  // no copy
//   recon::NamedField velocity = grains.field("velocity", {"vx", "vy", "vz"});
//   recon::PeriodicDomain<double> domain = grains.domain();
// ```
//
// Units are those of the source. Views refer to the table: they stay valid while it lives, also
// when it is moved or columns are added, but not when it is copied from or assigned to.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "recon/fields/field_set.hpp"
#include "recon/fields/text_cells.hpp"
#include "recon/points/domain.hpp"
#include "recon/points/view.hpp"

namespace recon {

// The axis (0, 1, 2 for x, y, z) along which a column of this name holds coordinates: x, X, xu, ...
std::optional<int> axis_of_coordinate(std::string_view name);
// A column of a file. `texts` are the cells that hold no numbers, and whose values are NaN.
struct ReadColumn {
  std::string name;
  std::vector<double> values;
  TextCells texts;
};

// The cell of a triclinic simulation: a corner, and the three vectors from it along its edges
// (lengths).
struct SimulationCell {
  std::array<double, max_dimension> origin{};
  std::array<std::array<double, max_dimension>, max_dimension> edges{};
};

class ParticleTable {
 public:
  // --- columns ---------------------------------------------------------------------------------
  // Throws InvalidArgument for an empty name, a name used twice, a length unlike that of the
  // others.
  void add_column(std::string name, std::vector<double> values);
  // As a reader has them. A name may be there several times: then no column can be asked for by it.
  void add_read_columns(std::vector<ReadColumn> columns);

  std::size_t size() const { return columns_.empty() ? 0 : columns_.front().values.size(); }
  // The columns that hold nothing but numbers and empty cells, under names of their own.
  const std::vector<std::string>& names() const { return names_; }
  // The columns in which text stands, and the names that several columns have.
  std::vector<std::string> text_columns() const;
  std::vector<std::string> repeated_names() const;
  // The first text in a column: "'Fe' on line 10"; "" where there is none.
  std::string describe_text(std::string_view name) const;
  // Whether there is a column of this name, whatever it holds.
  bool has(std::string_view name) const { return columns_by_name_.contains(name); }

  // Values of one column, all finite. Throws InvalidArgument for an unknown name (with the nearest
  // valid ones), for one of several columns, and for a cell that is no finite number. Cost
  // O(size()).
  const std::vector<double>& column(std::string_view name) const;
  const std::vector<double>& raw_column(std::string_view name) const;

  // Leaves the rows out for which `kept` is false. Throws InvalidArgument unless it has one entry
  // per row.
  void keep_rows(const std::vector<bool>& kept);

  // Cells that hold no value, in all columns: those whose text is `marker`, and those whose number
  // is that of `marker`, if it is one (-9999 is also -9999.0; nan is any NaN). "" means empty cells.
  void declare_missing(std::string_view marker);
  // Leaves out the particles that have no value in one of these columns, and says so in `remarks`.
  // Their number.
  std::size_t leave_out_missing(const std::vector<std::string>& columns);

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
  // A triclinic one: the box is that around the cell. Searches know periods along the axes only, so
  // particles are periodic along an axis where a periodic edge is parallel to it (to 1e-12), and
  // nowhere else; a remark says what is left out.
  void set_cell(const SimulationCell& cell, std::array<bool, max_dimension> periodic);
  // The cell, where one was set and not all its edges are along the axes.
  const std::optional<SimulationCell>& cell() const { return cell_; }

  // Box and periodic axes in the axes of coordinates(dimension): where these are, say, x and z, the
  // box has these two.
  // Without a box of the source: the bounding box of the positions, periodic nowhere.
  Box<double> box(int dimension = 0) const;
  PeriodicDomain<double> domain(int dimension = 0) const;
  // The same with a period along every axis that can have one, whatever the source says.
  PeriodicDomain<double> possible_domain(int dimension = 0) const;
  // Why an axis of coordinates(dimension) cannot be periodic: "" if it can.
  std::string why_not_periodic(int axis, int dimension = 0) const;

  // --- where the data come from ----------------------------------------------------------------
  std::string source;                // "chute.dump.gz, frame 5, step 50000"
  std::optional<std::int64_t> step;  // number of the time step
  std::optional<double> time;        // in the units of the source
  std::string units;                 // name of the unit system (LAMMPS: "lj", "si", ...), or empty
  std::vector<std::string> remarks;  // what the reader left out or assumed, for the user to see

  // Lines of the source, one per row; empty where there are none.
  void set_lines(std::vector<std::size_t> lines);

  // "row 17 (id 42, line 27)", rows counted from 0: for messages about a particle.
  std::string describe_row(std::size_t row) const;

 private:
  struct Column : ReadColumn {
    std::vector<std::uint32_t> missing;  // rows without a value, which is NaN
    bool repeated = false;               // another column has the same name
    bool is_numbers() const;
  };
  struct Hash : std::hash<std::string_view> {
    using is_transparent = void;
  };

  void add(ReadColumn column);
  const Column& find(std::string_view name) const;
  void update_names();
  void require_finite(const Column& column) const;
  std::vector<std::string> detected_coordinates() const;
  std::vector<std::string> varying_coordinates() const;
  std::vector<int> box_axes(int dimension) const;

  std::vector<Column> columns_;
  std::unordered_map<std::string, std::size_t, Hash, std::equal_to<>> columns_by_name_;
  std::vector<std::string> names_;
  std::vector<std::string> coordinates_;
  std::optional<Box<double>> box_;
  std::optional<SimulationCell> cell_;
  PeriodicDomain<double> periods_;  // along x, y, z, as far as there can be some
  std::array<bool, max_dimension> periodic_{};
  std::vector<std::size_t> lines_;
};

}  // namespace recon
