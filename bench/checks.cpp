#include "checks.hpp"

#include <algorithm>

#include "table.hpp"
#include "timing.hpp"

namespace recon_bench {

bool Checks::hold(bool condition, const std::string& what) {
  ++done_;
  if (!condition) {
    failures_.push_back(what);
    progress("  WRONG: " + what);
  }
  return condition;
}

bool Checks::within(double worst_ratio, const std::string& what) {
  if (worst_ratio <= 1) worst_ = std::max(worst_, worst_ratio);
  return hold(worst_ratio <= 1, what + ": off by " + number(worst_ratio) + " tolerances");
}

}  // namespace recon_bench
