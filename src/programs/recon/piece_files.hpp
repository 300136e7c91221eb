// The files of a grid that several ranks write: a piece of each, and one that names the pieces.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "programs/common/everyone.hpp"

namespace recon::program {

// a_2.vti, beside a.pvti.
std::filesystem::path piece_name(const std::filesystem::path& out, int rank);

// What all ranks read or write must be the same for all. Each function is called by all of them, and
// fails for all with a ProgramError.

// That the file has the same length, beginning and end for all.
void require_same_input(const Everyone& ranks, const std::string& file);

class PieceFiles {
 public:
  // Of a.pvti. Checks that each piece can be written.
  PieceFiles(const std::filesystem::path& out, const Everyone& ranks);

  // Writes the piece of this rank, where it has any, to the path that it is given. Pieces take their
  // names when all have been written, beside a.pvti; then the first rank writes the list, and pieces
  // that a.pvti has named before and names no more are removed.
  void write(bool any, const std::function<void(const std::filesystem::path&)>& piece,
             const std::function<void()>& list) const;

 private:
  void on_disk(const std::function<void()>& work) const;

  std::filesystem::path out_, piece_;
  const Everyone& ranks_;
};

}  // namespace recon::program
