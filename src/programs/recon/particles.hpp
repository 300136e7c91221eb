// The particles of a run: read from the file, with the coordinates, box and periods the user chose.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "programs/common/everyone.hpp"
#include "recon/fields/particle_table.hpp"
#include "recon/io/read.hpp"
#include "recon/points/structured_grid.hpp"

namespace CLI {
class App;
}

namespace recon::program {

struct InputOptions {
  std::string file;
  std::vector<std::string> more_files;  // of a series
  int frame = -1;
  std::string frames;                // all, or a range; see frames.hpp
  std::optional<std::int64_t> step;  // or by its step or time
  std::optional<double> time;
  std::string group;    // of particles, in HDF5
  std::string columns;  // names of all columns, if not from the file
  std::size_t skip_rows = 0;
  std::vector<std::string> missing;  // what stands for "no value"
  int dimension = 0;                 // 0: as detected
  std::string coordinates;
  std::string periodic = "from-file";
  std::string bounds;
  std::string where;  // see where.hpp; all particles if empty
};

// A coordinate that is not used.
struct LeftOut {
  std::string name;
  std::optional<int> axis;      // x, y or z, where the name tells it
  std::optional<double> place;  // of all particles, where it is the same
};

struct Particles {
  InputOptions options;
  ParticleTable table;
  // Who has read the rest, where the table holds a part of the particles only. What follows is of
  // all of them.
  const Everyone* everyone = &Everyone::alone();
  std::size_t in_all = 0;
  std::vector<std::string> text_elsewhere;  // columns that hold text in parts of others
  int dimension = 0;
  std::vector<std::string> axes;  // names of the coordinate columns
  std::string letters;            // "xz": which of x, y, z each of them is, for derived names
  std::vector<LeftOut> left_out;
  Box<double> extent;  // of the particles; along periodic axes the period
  Box<double> region;  // where a grid goes: --bounds, else the extent
  PeriodicDomain<double> domain;
  PeriodicDomain<double> grid_domain;  // periodic where the region covers the whole period
  // Of the particles, a length: that of a regular lattice of as many points in the extent, or that
  // of their own density where they do not fill the extent; 0 if all are at one place.
  // Not known (0) where no process has all particles.
  double spacing = 0;
  double box_spacing = 0;  // the former

  std::size_t size() const { return table.size(); }
  PointsView<double> positions() const { return table.positions(dimension); }
  // The axis of this name: that of its column, or x, y, z by place. `option` is for the message.
  int axis(std::string_view name, const std::string& option) const;
  // "chute.dump.gz, frame 5, step 50000: 3,000 particles in 3-D, periodic in x and y"; what is left
  // out is said: "in 2-D (x and z; y = 0.5 for all)".
  std::string describe() const;
};

void add_input_options(CLI::App& app, InputOptions& options);
// Those that say what is read, without dimension and periods.
void add_file_options(CLI::App& app, InputOptions& options);

// What the options mean for the reader of the file.
ReadOptions read_options(const InputOptions& options);

// Ends with wrong_input for what is wrong with the file, wrong_usage for what is with the options:
// also for a choice of several frames.
Particles read_input(const InputOptions& options);
// The particles of a table that was read; with others who have read the rest (collective).
Particles make_particles(ParticleTable table, const InputOptions& options,
                         const Everyone& everyone = Everyone::alone());

// Leaves out the particles without a value in one of these columns, which are to be used.
// Collective.
void leave_out_missing(Particles& particles, const std::vector<std::string>& columns);

// A spacing of targets near that of the particles, of one or two digits; not less than half of
// what the box would have, so that a grid does not grow beyond reason.
double suggested_spacing(const Particles& particles);
// A radius, the same everywhere, in which a fit of this degree has neighbours enough.
double suggested_radius(const Particles& particles, int degree);

}  // namespace recon::program
