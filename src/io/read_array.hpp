// Arrays with several components for each particle, as binary formats have them, and the columns of
// a table that they become.
//
// A single number keeps the name of its array. Coordinates (position, positions, pos, coordinates)
// become x, y, z; velocity, velocities, velo, vel become vx, vy, vz, and force, forces fx, fy, fz,
// as LAMMPS calls them; image becomes ix, iy, iz. Of any other name, two or three components get
// the endings _x, _y, _z, nine get _xx, _xy, ..., _zz and four in a plane _xx, _xy, _yx, _yy if
// they are named so in the file, and the rest get _0, _1, ...
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "recon/fields/particle_table.hpp"

namespace recon::detail {

struct ReadArray {
  std::string name;
  int components = 1;
  std::vector<double> values;                // point after point
  std::vector<std::string> component_names;  // where the file has them
  bool whole = false;                        // to be written as whole numbers
};

std::string column_name(const std::string& array, int component, int components,
                        const std::vector<std::string>& component_names = {});

// Appends the columns of an array.
void add_columns(const ReadArray& array, std::vector<ReadColumn>& columns);

// The arrays that columns make up by the same rules, in the order of their first columns: vx, vy,
// vz become velocity, s_xx, s_xy, ..., s_zz become s, what is left stays single. `names` are the
// columns of the table that count, and have numbers only (or none: NaN).
std::vector<ReadArray> arrays_of(const ParticleTable& table, const std::vector<std::string>& names);

}  // namespace recon::detail
