#include <cmath>

#include "number_text.hpp"
#include "recon/core/error.hpp"
#include "recon/io/atomic_file.hpp"
#include "recon/io/series.hpp"
#include "xml_text.hpp"

namespace recon {

void write_pvd(const std::filesystem::path& path, const std::vector<SeriesEntry>& entries) {
  for (const SeriesEntry& entry : entries)
    require(std::isfinite(entry.time), "time of a file of a series", entry.time, "must be finite");
  AtomicFile file(path);
  file.write(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\">\n  <Collection>\n");
  for (const SeriesEntry& entry : entries)
    file.write(detail::join("    <DataSet timestep=\"", entry.time, "\" part=\"0\" file=\"",
                            detail::escaped(entry.file), "\"/>\n"));
  file.write("  </Collection>\n</VTKFile>\n");
  file.commit();
}

}  // namespace recon
