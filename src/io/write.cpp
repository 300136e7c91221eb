#include "recon/io/write.hpp"

#include <algorithm>
#include <cctype>
#include <string>
#include <vector>

#include "recon/core/names.hpp"

namespace recon {

namespace {

std::string extension(const std::filesystem::path& path) {
  std::string text = path.extension().string();
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

}  // namespace

void require_writable_extension(const std::filesystem::path& path, bool grid) {
  const std::vector<std::string> known{".csv", grid ? ".vti" : ".vtp"};
  const std::string own = extension(path);
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
  if (extension(path) == ".vti") return write_vti(path, grid, fields);
  const auto nodes = grid.nodes();
  write_csv(path, nodes.view(), fields);
}

void write(const std::filesystem::path& path, const PointsView<double>& points,
           const FieldSet& fields) {
  require_writable_extension(path, false);
  if (extension(path) == ".vtp") return write_vtp(path, points, fields);
  write_csv(path, points, fields);
}

}  // namespace recon
