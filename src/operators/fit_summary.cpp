#include "recon/operators/fit_summary.hpp"

#include <algorithm>

namespace recon {

FitReports::FitReports(std::vector<FitReport> reports, Solver asked)
    : reports_(std::move(reports)) {
  FitSummary& s = summary_;
  s.targets = reports_.size();
  if (!reports_.empty()) s.fewest_neighbours = reports_.front().neighbours;
  for (const FitReport& report : reports_) {
    s.full += report.status == FitStatus::full;
    s.reduced += report.status == FitStatus::reduced;
    s.nearest += report.status == FitStatus::nearest;
    s.no_support += report.status == FitStatus::no_support;
    s.too_far += report.status == FitStatus::too_far;
    s.fewest_neighbours = std::min<std::size_t>(s.fewest_neighbours, report.neighbours);
    s.most_neighbours = std::max<std::size_t>(s.most_neighbours, report.neighbours);
    s.mean_neighbours += report.neighbours;
    if (report.status != FitStatus::full && report.status != FitStatus::reduced) continue;
    s.handed_over += report.solver != asked;
    s.smallest_pivot = std::min<double>(s.smallest_pivot, report.smallest_pivot);
    s.largest_amplification = std::max<double>(s.largest_amplification, report.amplification);
  }
  if (s.targets > 0) s.mean_neighbours /= static_cast<double>(s.targets);
}

std::vector<std::size_t> FitReports::with_status(FitStatus status) const {
  std::vector<std::size_t> targets;
  for (std::size_t t = 0; t < reports_.size(); ++t)
    if (reports_[t].status == status) targets.push_back(t);
  return targets;
}

}  // namespace recon
