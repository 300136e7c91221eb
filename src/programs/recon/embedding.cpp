#include "embedding.hpp"

#include <algorithm>

#include "recon/io/write.hpp"

namespace recon::program {

namespace {

using Axes = std::array<int, max_dimension>;  // of space; -1 where the data have none

// For each axis of space the axis of the data that lies along it.
Axes data_axes(const Particles& particles) {
  Axes axes{-1, -1, -1};
  for (int d = 0; d < particles.dimension; ++d)
    axes[particles.letters[static_cast<std::size_t>(d)] - 'x'] = d;
  return axes;
}

bool lies_first(const Particles& particles) {
  return std::string("xyz").starts_with(particles.letters);
}

// Where on an axis that the data do not have they lie.
double place_on(const Particles& particles, int axis) {
  for (const LeftOut& each : particles.left_out)
    if (each.axis == axis) return each.place.value_or(0);
  return 0;
}

// Vectors of the data's axes as vectors in space.
FieldSet in_space(const FieldSet& fields, const Axes& axes, int dimension) {
  FieldSet spatial;
  spatial.step = fields.step;
  spatial.time = fields.time;
  for (const NamedField& field : fields) {
    if (dimension == 1 || field.components != dimension) {
      spatial.add(field);
      continue;
    }
    std::vector<double> values;
    values.reserve(field.size() * max_dimension);
    for (std::size_t i = 0; i < field.size(); ++i)
      for (const int axis : axes) values.push_back(axis < 0 ? 0 : field.view()(i, axis));
    spatial.add(field.name, max_dimension, std::move(values), field.type);
  }
  return spatial;
}

}  // namespace

void write_embedded(const std::string& path, const Particles& particles,
                    const StructuredGrid<double>& grid, const FieldSet& fields) {
  if (lies_first(particles)) return write(path, grid, fields);
  const Axes axes = data_axes(particles);
  // Nodes of the grid run along its first axis fastest, those of space along x: the same order only
  // where the axes are in order.
  if (!std::is_sorted(particles.letters.begin(), particles.letters.end()))
    return write(path, grid, fields);
  StructuredGrid<double> spatial;
  for (int axis = 0; axis < max_dimension; ++axis) {
    const int d = axes[axis];
    spatial.origin[axis] = d < 0 ? place_on(particles, axis) : grid.origin[d];
    spatial.spacing[axis] = d < 0 ? grid.spacing[0] : grid.spacing[d];
    spatial.counts[axis] = d < 0 ? 1 : grid.count(d);
  }
  write(path, spatial, in_space(fields, axes, grid.dimension));
}

void write_embedded(const std::string& path, const Particles& particles,
                    const PointsView<double>& points, const FieldSet& fields) {
  if (lies_first(particles)) return write(path, points, fields);
  const Axes axes = data_axes(particles);
  std::array<std::vector<double>, max_dimension> coordinates;
  for (int axis = 0; axis < max_dimension; ++axis) {
    const double place = axes[axis] < 0 ? place_on(particles, axis) : 0;
    for (std::size_t i = 0; i < points.size(); ++i)
      coordinates[axis].push_back(axes[axis] < 0 ? place : points(i, axes[axis]));
  }
  write(path, points_of_axes(coordinates, max_dimension),
        in_space(fields, axes, points.dimension()));
}

}  // namespace recon::program
