// Particles as a table of named columns of numbers, one row per particle, as files have them.
//
// A table also carries what is known about its particles as a whole: step and time, the simulation
// box, which axes are periodic, where the data come from, and the reader's remarks. Rows keep the
// order of the source; a row remembers its line there, so that a message can name it.
//
// Coordinates. Unless set_coordinates() names the columns, the coordinates along x are sought under
// the names x, X, xu, Points:0, Points_0 in this order, and likewise for y and z (xu is LAMMPS'
// unwrapped coordinate, Points:0 what ParaView writes). The dimension is the number of axes that
// have a column. An axis along which all of two or more particles have the same coordinate does not
// count, unless that holds for every axis: particles in a plane y = 0.5 are 2-D in x and z. To have
// them in 3-D, ask for positions(3).
//
// Columns are checked when they are used. A file may hold labels, words among numbers, empty
// cells or a name twice: as long as nobody asks for such a column, that is no error. column(),
// field() and positions() give finite numbers only. Otherwise they throw InvalidArgument that
// names the column, the row, the particle's id where there is a column `id`, the line and the
// source, or the columns that share the name. raw_column() gives the numbers as they are, with
// NaN where a cell holds none.
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

// A triclinic simulation cell: one corner, and the vectors from it along the three edges; lengths.
struct SimulationCell {
  std::array<double, max_dimension> origin{};
  std::array<std::array<double, max_dimension>, max_dimension> edges{};
};

class ParticleTable {
 public:
  // --- columns ---------------------------------------------------------------------------------
  // Throws InvalidArgument for an empty name, a name used twice, or a length unlike the others.
  void add_column(std::string name, std::vector<double> values);
  // Adds columns as a file has them. A name may occur several times: a column of that name
  // cannot be asked for.
  void add_read_columns(std::vector<ReadColumn> columns);

  std::size_t size() const { return columns_.empty() ? 0 : columns_.front().values.size(); }
  // The names of the columns that hold only numbers and empty cells, and share their
  // name with no other.
  const std::vector<std::string>& names() const { return names_; }
  // The columns in which text stands, and the names that several columns have.
  std::vector<std::string> text_columns() const;
  std::vector<std::string> repeated_names() const;
  // The first text in a column, for example "'Fe' on line 10"; "" where there is none.
  std::string describe_text(std::string_view name) const;
  // The names of all columns that share theirs with no other, in the order of the source, and the
  // cells of one that are no numbers.
  std::vector<std::string> all_names() const;
  const TextCells& texts(std::string_view name) const;
  // Whether there is a column of this name, whatever it holds.
  bool has(std::string_view name) const { return columns_by_name_.contains(name); }

  // The values of one column. column() throws InvalidArgument for an unknown name (with the nearest
  // valid ones), for a name that several columns have, and for a cell that is no finite number.
  // Cost O(size()). raw_column() does not check values.
  const std::vector<double>& column(std::string_view name) const;
  const std::vector<double>& raw_column(std::string_view name) const;

  // Drops the rows whose entry of `kept` is false. Throws InvalidArgument unless there
  // is one per row.
  void keep_rows(const std::vector<bool>& kept);

  // Declares what marks a cell without a value, in all columns: cells whose text is `marker`, and
  // cells whose number equals `marker` if that is a number (-9999 is also -9999.0; nan is any NaN).
  // "" means empty cells.
  void declare_missing(std::string_view marker);
  // Drops the particles that have no value in one of these columns, and says so in `remarks`.
  // Returns how many were dropped.
  std::size_t leave_out_missing(const std::vector<std::string>& columns);

  // Several columns as one field, point-major. The components are the columns in the order given.
  NamedField field(std::string name, const std::vector<std::string>& columns) const;

  // --- coordinates -----------------------------------------------------------------------------
  // The columns that hold the coordinates, 1 to 3 of them; checked when they are used.
  void set_coordinates(std::vector<std::string> columns);
  // The columns used in `dimension` dimensions (0: as detected); throws where there are fewer.
  std::vector<std::string> coordinates(int dimension = 0) const;
  // The columns that were set or found, also those that count as no axis because they are constant.
  std::vector<std::string> all_coordinates() const;
  // Along which of x, y and z (0, 1, 2) each column of coordinates(dimension) lies: the axis that
  // its name tells, or else its position in the list. Where two columns would lie along the same
  // axis, the positions hold for all.
  std::vector<int> axes(int dimension = 0) const;
  // The number of axes by the rule at the top. Throws InvalidArgument where no column x,
  // y or z is found.
  int dimension() const;

  // Throws InvalidArgument for a coordinate that is NaN or infinite. dimension = 0: as detected.
  PointsView<double> positions(int dimension = 0) const;

  // --- the simulation box ----------------------------------------------------------------------
  // The box that the source has, along x, y, z; `box` may have fewer dimensions than three.
  void set_box(const Box<double>& box, std::array<bool, max_dimension> periodic);
  bool has_box() const { return box_.has_value(); }
  // Sets a triclinic cell; the box is then its bounding box. Searches know periods along the axes
  // only. So particles are periodic along an axis where a periodic edge is parallel to it (to
  // 1e-12), and nowhere else; a remark says which periods are ignored.
  void set_cell(const SimulationCell& cell, std::array<bool, max_dimension> periodic);
  // The cell, where one was set and not all its edges are along the axes.
  const std::optional<SimulationCell>& cell() const { return cell_; }

  // The cell or box as three edges in x, y, z, whatever they are, and which of them the source says
  // to be periodic; nothing without a box.
  std::optional<SimulationCell> source_cell() const;
  std::array<bool, max_dimension> periodic_edges() const { return periodic_edges_; }

  // The box and the periodic domain in the axes of coordinates(dimension): where these are x and z,
  // the box has these two. Without a box of the source they are the bounding box of the positions,
  // periodic nowhere.
  Box<double> box(int dimension = 0) const;
  PeriodicDomain<double> domain(int dimension = 0) const;
  // The domain with a period along every axis that can have one, whatever the source says.
  PeriodicDomain<double> possible_domain(int dimension = 0) const;
  // Says why an axis of coordinates(dimension) cannot be periodic; "" if it can.
  std::string why_not_periodic(int axis, int dimension = 0) const;

  // --- where the data come from ----------------------------------------------------------------
  std::string source;                // "chute.dump.gz, frame 5, step 50000"
  std::optional<std::int64_t> step;  // number of the time step
  std::optional<double> time;        // in the units of the source
  std::string units;                 // name of the unit system (LAMMPS: "lj", "si", ...), or empty
  std::vector<std::string> remarks;  // what the reader left out or assumed, for the user to see

  // The line of the source at which each row stands; empty where rows have no lines.
  void set_lines(std::vector<std::size_t> lines);

  // The row of the source that each row was, counted from 0: other ones where only some were read.
  // Throws InvalidArgument unless there is one per row.
  void set_source_rows(std::vector<std::size_t> rows);

  // How messages call a particle: "row 17 (id 42, line 27)", with rows of the source counted from 0.
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
  std::array<bool, max_dimension> periodic_{}, periodic_edges_{};
  std::vector<std::size_t> lines_;
  std::vector<std::size_t> source_rows_;  // empty: none was left out
};

}  // namespace recon
