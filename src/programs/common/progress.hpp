// How far the work is, on the standard error: nothing for the first second; then one line that is
// written over on a terminal, and elsewhere a line every ten seconds.
#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace recon::program {

class Progress {
 public:
  Progress(std::string label, std::size_t total, bool quiet);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void advance(std::size_t amount);
  double seconds() const;

 private:
  std::string label_;
  std::size_t total_, done_ = 0;
  bool quiet_, terminal_, shown_ = false;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  double last_shown_ = 0;  // seconds after the start
};

}  // namespace recon::program
