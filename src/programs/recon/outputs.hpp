// The files that a run writes.
#pragma once

#include <string>
#include <vector>

namespace recon::program {

// Ends before the work begins what would fail after it: an extension that nothing writes, a folder
// that is missing or write-protected, two outputs or an input and an output that are the same file.
// csv_only: no VTK.
void check_outputs(const std::vector<std::string>& outputs, const std::string& picture,
                   const std::vector<std::string>& inputs, bool grid, bool csv_only = false);

// The part of it that holds for any files.
void check_files(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs);

// The file that an output is written to, and for "-" a temporary one, whose bytes then go to the
// standard output: as with files, nothing is written unless all is.
class OutputPlace {
 public:
  explicit OutputPlace(const std::string& output);
  ~OutputPlace();
  OutputPlace(const OutputPlace&) = delete;
  OutputPlace& operator=(const OutputPlace&) = delete;
  const std::string& path() const { return path_; }
  // Once the file is written.
  void send() const;

 private:
  std::string path_, folder_;
};

// "1.2 MB" and the like.
std::string file_size(const std::string& path);

}  // namespace recon::program
