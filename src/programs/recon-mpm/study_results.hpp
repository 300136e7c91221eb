// What has been measured, one file for each study: runs that are there are not made again.
#pragma once

#include <filesystem>
#include <string>

#include "judge.hpp"

namespace recon::program {

// Lines of "mark variant method grid quantity value", with tabs between them. The mark stands for
// all that defines a run besides its method and grid: kind of study, problem file, settings. Lines
// with another mark, or of a variant, method or grid that the study does not have, belong to an
// older definition and are left out. A run begins with its sum, which stands for all its lines: a run
// that has been changed since, or has lost a line, is refused.
class ResultFile {
 public:
  // An empty folder: nothing is kept. Throws FileError for a line that cannot be read, and for a run
  // that is not as it was written.
  ResultFile(const std::filesystem::path& folder, const Study& study);
  const StudyResults& runs() const { return runs_; }
  // Adds a run and writes the file. Throws FileError.
  void add(const RunKey& key, const Measured& measured);

 private:
  std::string mark(const std::string& variant) const;
  void read();
  void write() const;

  const Study* study_;
  std::filesystem::path path_;
  StudyResults runs_;
};

// All runs of a study on these grids, in their order.
std::vector<RunKey> runs_on(const Study& study, const std::vector<int>& grids);
// The finest grids last, each once.
std::vector<int> joined(const std::vector<int>& a, const std::vector<int>& b);

}  // namespace recon::program
