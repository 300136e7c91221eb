#include "programs/common/progress.hpp"

#include <unistd.h>

#include <cmath>
#include <cstdio>

namespace recon::program {

Progress::Progress(std::string label, std::size_t total, bool quiet)
    : label_(std::move(label)),
      total_(total),
      quiet_(quiet),
      terminal_(isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (shown_ && terminal_) std::fputs("\r\033[K", stderr);
}

double Progress::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

void Progress::advance(std::size_t amount) {
  done_ += amount;
  const double now = seconds(), wait = shown_ ? (terminal_ ? 0.2 : 10.0) : 1.0;
  if (quiet_ || done_ >= total_ || now - last_shown_ < wait) return;
  const double part = static_cast<double>(done_) / static_cast<double>(total_);
  std::fprintf(stderr, "%s%s: %2.0f %%, about %.0f s left%s", terminal_ ? "\r\033[K" : "",
               label_.c_str(), std::floor(100 * part), std::ceil(now * (1 - part) / part),
               terminal_ ? "" : "\n");
  std::fflush(stderr);
  shown_ = true;
  last_shown_ = now;
}

}  // namespace recon::program
