#include "recon/io/picture.hpp"

#include "recon/core/error.hpp"
#include "recon/core/names.hpp"

namespace recon {

namespace {
using detail::require;
}  // namespace

GridSlice slice(const StructuredGrid<double>& grid, std::span<const double> values, int axis,
                std::size_t index) {
  grid.validate();
  require(grid.dimension >= 2, "dimension of the grid", grid.dimension,
          "must be at least 2 to take a slice");
  require(axis >= 0 && axis < grid.dimension, "axis of the slice", axis,
          "must be an axis of the grid, counted from 0");
  if (index >= grid.count(axis))
    detail::throw_invalid(
        "index of the slice", index,
        "must be below the number of nodes along the axis, " + std::to_string(grid.count(axis)));
  if (values.size() != grid.size())
    detail::throw_invalid(
        "number of values", values.size(),
        "must be one per node, of which there are " + std::to_string(grid.size()));
  GridSlice result;
  result.grid.dimension = grid.dimension - 1;
  for (int d = 0, kept = 0; d < grid.dimension; ++d) {
    if (d == axis) continue;
    result.grid.origin[kept] = grid.origin[d];
    result.grid.spacing[kept] = grid.spacing[d];
    result.grid.counts[kept++] = grid.count(d);
  }
  result.values.reserve(result.grid.size());
  for (std::size_t node = 0; node < grid.size(); ++node)
    if (grid.index(node)[axis] == index) result.values.push_back(values[node]);
  return result;
}

void require_picture_extension(const std::filesystem::path& path) {
  const std::string own = path.extension().string();
  const std::vector<std::string> known{".png", ".svg"};
  for (const std::string& each : known)
    if (edit_distance(own, each) == 0) return;  // ignores case
  throw FileError(path, 0, "'" + own + "' is no extension of a picture: .png or .svg is needed");
}

}  // namespace recon
