#include "recon/io/write.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "core/lower_case.hpp"
#include "recon/core/names.hpp"

namespace recon {

void require_writable_extension(const std::filesystem::path& path, bool grid) {
  const std::vector<std::string> known{".csv", grid ? ".vti" : ".vtp"};
  const std::string own = detail::lower_case(path.extension().string());
  if (std::find(known.begin(), known.end(), own) != known.end()) return;
  const std::string what = grid ? "fields on a grid" : "fields at points";
  const std::string other = grid ? ".vtp" : ".vti";
  throw FileError(
      path, 0,
      (own.empty() ? "the name has no extension"
       : own == other
           ? "the extension " + own + (grid ? " is for points" : " is for a grid")
           : "'" + own + "' is no extension that can be written (" + suggest(own, known) + ")") +
          "; " + what + " are written as " + known[0] + " or " + known[1]);
}

void write(const std::filesystem::path& path, const StructuredGrid<double>& grid,
           const FieldSet& fields) {
  require_writable_extension(path, true);
  if (detail::lower_case(path.extension().string()) == ".vti") return write_vti(path, grid, fields);
  const auto nodes = grid.nodes();
  write_csv(path, nodes.view(), fields);
}

void write(const std::filesystem::path& path, const PointsView<double>& points,
           const FieldSet& fields) {
  require_writable_extension(path, false);
  if (detail::lower_case(path.extension().string()) == ".vtp")
    return write_vtp(path, points, fields);
  write_csv(path, points, fields);
}

}  // namespace recon
