// Answers are checked before they are timed; a wrong one is not timed, and fails the whole run.
#pragma once

#include <string>
#include <vector>

namespace recon_bench {

class Checks {
 public:
  // Counts the check; true if it holds. A failure is remembered with its message.
  bool hold(bool condition, const std::string& what);

  // |difference| / tolerance at its worst, which must be at most 1.
  bool within(double worst_ratio, const std::string& what);

  int done() const { return done_; }
  double worst() const { return worst_; }  // of all calls of within() that held
  const std::vector<std::string>& failures() const { return failures_; }

 private:
  int done_ = 0;
  double worst_ = 0;
  std::vector<std::string> failures_;
};

// What stands in a table instead of the times of a wrong answer.
inline constexpr const char* wrong_answer = "WRONG ANSWER";

}  // namespace recon_bench
