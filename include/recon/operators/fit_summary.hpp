// All reports of a reconstruction, and a summary of them.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "recon/local_solve/report.hpp"

namespace recon {

// Counts and extremes over all targets. Conditioning is taken over the targets that have a fit.
struct FitSummary {
  std::size_t targets = 0, full = 0, reduced = 0, nearest = 0, no_support = 0, too_far = 0;
  std::size_t handed_over = 0;  // targets that another solver than the asked one had to solve
  std::size_t fewest_neighbours = 0, most_neighbours = 0;
  double mean_neighbours = 0;
  double smallest_pivot = 1, largest_amplification = 1;
};

class FitReports {
 public:
  FitReports() = default;
  FitReports(std::vector<FitReport> reports, Solver asked);

  std::size_t size() const { return reports_.size(); }
  const FitReport& operator[](std::size_t target) const { return reports_[target]; }
  std::span<const FitReport> all() const { return reports_; }

  const FitSummary& summary() const { return summary_; }
  std::size_t reduced() const { return summary_.reduced; }
  std::size_t no_support() const { return summary_.no_support; }
  std::size_t too_far() const { return summary_.too_far; }

  // Leaves nothing here; for new reports in the same memory.
  std::vector<FitReport> give_up() { return std::move(reports_); }

  // The targets with this status, ascending.
  std::vector<std::size_t> with_status(FitStatus status) const;

 private:
  std::vector<FitReport> reports_;
  FitSummary summary_;
};

}  // namespace recon
