#include <cmath>

#include "escaped.hpp"
#include "number_text.hpp"
#include "recon/core/error.hpp"
#include "recon/fields/utf8.hpp"
#include "recon/io/atomic_file.hpp"
#include "recon/io/write.hpp"

namespace recon {

namespace {
using detail::require;
}  // namespace

void write_pvd(const std::filesystem::path& path, const std::vector<TimedFile>& files) {
  std::string xml =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\">\n  <Collection>\n";
  for (const TimedFile& file : files) {
    const std::string name = file.file.generic_string();
    require(std::isfinite(file.time), "time of a frame", file.time, "must be finite");
    require(is_utf8(name), "name of a file in a series", to_utf8(name), "must be UTF-8");
    for (const char c : name)
      require(static_cast<unsigned char>(c) >= 0x20, "name of a file in a series", name,
              "must not contain line breaks or other control characters");
    xml += "    <DataSet timestep=\"";
    detail::append_number(xml, file.time);
    xml += "\" part=\"0\" file=\"" + detail::escaped(name) + "\"/>\n";
  }
  AtomicFile out(path);
  out.write(xml + "  </Collection>\n</VTKFile>\n");
  out.commit();
}

}  // namespace recon
