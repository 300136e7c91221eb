// A picture of mapped fields: a plane through a 3-D grid, all of a 2-D one, curves over a 1-D one.
#pragma once

#include <string>
#include <vector>

#include "particles.hpp"
#include "recon/fields/field_set.hpp"
#include "recon/points/structured_grid.hpp"

namespace recon::program {

struct PictureOptions {
  std::string file;
  std::string fields;   // names, at most a few; the first field if empty
  std::string slice;    // "z=5"; the middle of y if empty
  std::string colours;  // "0,1", or "all"; without outliers if empty
};

// Where a 3-D grid is cut: the nodes `index` along `axis`.
struct Cut {
  int axis = 1;
  std::size_t index = 0;
};

// Ends with wrong_usage where the slice is no plane of the grid, or the colours are no range.
Cut choose_cut(const PictureOptions& options, const Particles& particles,
               const StructuredGrid<double>& grid);

// Gives back what lies beyond the colours, in words; nothing if nothing does.
std::string draw_fields(const PictureOptions& options, const Cut& cut, const Particles& particles,
                        const StructuredGrid<double>& grid, const FieldSet& fields);

}  // namespace recon::program
