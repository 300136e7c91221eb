#include "slice_picture.hpp"

#include <algorithm>
#include <cmath>

#include "programs/common/errors.hpp"
#include "programs/common/text.hpp"
#include "recon/io/picture.hpp"

namespace recon::program {

namespace {

// One number per node: the value, or the length of a vector.
std::vector<double> shown_values(const NamedField& field) {
  if (field.components == 1) return field.values;
  std::vector<double> lengths(field.size());
  for (std::size_t i = 0; i < field.size(); ++i) {
    double length = 0;
    for (int c = 0; c < field.components; ++c) length = std::hypot(length, field.view()(i, c));
    lengths[i] = length;
  }
  return lengths;
}

// --colours, if it names a range.
std::optional<Range> read_colours(const PictureOptions& options) {
  if (options.colours.empty() || options.colours == "all") return {};
  const std::vector<std::string> ends = split(options.colours);
  const auto lower = ends.size() == 2 ? to_number(ends[0]) : std::nullopt;
  const auto upper = ends.size() == 2 ? to_number(ends[1]) : std::nullopt;
  if (!lower || !upper || !(*lower < *upper))
    fail_usage("--colours " + options.colours + ": all, or a lower and a greater upper end are " +
               "needed, as in 0,1.5");
  return Range{*lower, *upper};
}

std::string label(const NamedField& field) {
  return field.components == 1 ? field.name : "|" + field.name + "|";
}

}  // namespace

Cut choose_cut(const PictureOptions& options, const Particles& particles,
               const StructuredGrid<double>& grid) {
  read_colours(options);
  if (options.slice.empty()) return {1, grid.counts[1] / 2};
  if (grid.dimension != 3) fail_usage("--slice is for grids in 3-D; this one is shown as a whole");
  const std::size_t equals = options.slice.find('=');
  const auto place =
      equals == std::string::npos ? std::nullopt : to_number(options.slice.substr(equals + 1));
  if (!place)
    fail_usage("--slice " + options.slice + ": an axis and a place are needed, as in z=5");
  Cut cut;
  cut.axis = particles.axis(options.slice.substr(0, equals), "--slice");
  const double first = grid.origin[cut.axis];
  const double last = grid.coordinate(grid.counts[cut.axis] - 1, cut.axis);
  const double step = (*place - first) / grid.spacing[cut.axis];
  if (step < -0.5 || *place > last + 0.5 * grid.spacing[cut.axis])
    fail_usage("--slice " + options.slice + ": the grid covers " + range(first, last));
  cut.index = std::min(static_cast<std::size_t>(std::lround(std::max(step, 0.0))),
                       grid.counts[cut.axis] - 1);
  return cut;
}

std::string draw_fields(const PictureOptions& options, const Cut& cut, const Particles& particles,
                        const StructuredGrid<double>& grid, const FieldSet& fields) {
  std::vector<std::string> names = split(options.fields);
  if (names.empty()) names.push_back(fields.begin()->name);
  std::vector<std::string> axes = particles.axes;
  HeatMap map;
  map.title = particles.table.source;
  if (grid.dimension == 3) {
    map.title += ", " + axes[cut.axis] + " = " +
                 number_within(grid.coordinate(cut.index, cut.axis), grid.origin[cut.axis],
                               grid.coordinate(grid.counts[cut.axis] - 1, cut.axis));
    axes.erase(axes.begin() + cut.axis);
  }
  map.x_label = axes[0];
  if (axes.size() > 1) map.y_label = axes[1];
  for (const std::string& name : names) {
    const NamedField& field = fields[name];
    HeatMapPanel panel;
    if (names.size() > 1) panel.title = label(field);
    if (names.size() == 1) map.colour_label = label(field);
    if (grid.dimension == 3) {
      GridSlice plane = slice(grid, shown_values(field), cut.axis, cut.index);
      panel.grid = plane.grid;
      panel.values = std::move(plane.values);
    } else {
      panel.grid = grid;
      panel.values = shown_values(field);
    }
    map.panels.push_back(std::move(panel));
  }
  map.colour_range = read_colours(options);
  if (options.colours == "all") {
    const ColourScale scale = colour_scale(map);
    if (scale.least < scale.greatest) map.colour_range = Range{scale.least, scale.greatest};
  }
  draw(options.file, map);
  return map.panels.front().grid.dimension == 1 ? "" : describe_beyond(colour_scale(map));
}

}  // namespace recon::program
