#include "runs/rows_file.hpp"

#include <cstdlib>

#include "recon/io/atomic_file.hpp"

namespace recon::mpm {

RowsFile::RowsFile(const std::filesystem::path& path, const std::string& header, bool goes_on,
                   std::int64_t first_step)
    : path_(path) {
  AtomicFile file(path);
  file.write(header + "\n");
  if (goes_on) {
    std::ifstream before(path);
    std::string line;
    if (std::getline(before, line) && line != header)
      throw FileError(
          path, 1,
          "has other columns than this run would add to: move the file away, or ask for "
          "the same columns");
    // A line without its end is one that a full disk has cut.
    while (std::getline(before, line) && !before.eof() && std::atoll(line.c_str()) < first_step)
      file.write(line + "\n");
  }
  file.commit();
  out_.open(path, std::ios::app);
}

void RowsFile::add(const std::string& row) {
  out_ << row << '\n';
  if (!out_) throw FileError(path_, 0, "could not be written");
}

void RowsFile::flush() {
  if (!out_.flush()) throw FileError(path_, 0, "could not be written");
}

}  // namespace recon::mpm
