// Are the answers of recon and of the hand-written loop the same? Each function gives the worst
// difference in units of its tolerance, or a huge number where the answers differ in kind.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "hand_written.hpp"
#include "recon/points/generate.hpp"
#include "recon/recon.hpp"

namespace recon_bench {

inline constexpr double differs_in_kind = 1e300;

// The same k particles for every target, up to particles whose distances are equal to rounding.
template <class Scalar, int D>
double compare_neighbours(const recon::NeighbourList<Scalar>& ours,
                          const hand_written::Neighbours<Scalar>& theirs,
                          const recon::PointList<Scalar, D>& sources,
                          const recon::PointList<Scalar, D>& targets) {
  const auto k = static_cast<std::size_t>(theirs.k);
  const double rounding = 8 * static_cast<double>(std::numeric_limits<Scalar>::epsilon());
  double worst = 0;
  std::vector<Scalar> distance2(k);
  if (ours.targets() != targets.size()) return differs_in_kind;
  for (std::size_t t = 0; t < targets.size(); ++t) {
    const auto list = ours.of(t);
    if (list.size() != k) return differs_in_kind;
    for (std::size_t j = 0; j < k; ++j) {
      Scalar sum = 0;
      for (int d = 0; d < D; ++d) {
        const Scalar offset = sources[list[j]][d] - targets[t][d];
        sum += offset * offset;
      }
      distance2[j] = sum;
    }
    std::sort(distance2.begin(), distance2.end());
    for (std::size_t j = 0; j < k; ++j) {
      const double theirs2 = static_cast<double>(theirs.distance2[t * k + j]);
      worst = std::max(worst, std::abs(static_cast<double>(distance2[j]) - theirs2) /
                                  (rounding * theirs2 + std::numeric_limits<double>::min()));
    }
    std::vector<recon::ParticleIndex> a(list.begin(), list.end());
    std::vector<recon::ParticleIndex> b(&theirs.index[t * k], &theirs.index[t * k] + k);
    std::sort(a.begin(), a.end());
    if (std::adjacent_find(a.begin(), a.end()) != a.end()) return differs_in_kind;  // listed twice
    std::sort(b.begin(), b.end());
    const bool tie = k > 1 && distance2[k - 1] - distance2[k - 2] <= rounding * distance2[k - 1];
    if (a != b && !tie) return differs_in_kind;
  }
  return worst;
}

// Values at targets whose fit has the full degree. The tolerance is rounding times the
// condition of the moment matrix (1 / smallest_pivot bounds it from below, hence the factor)
// times the amplification.
template <class Scalar, class Ours, class Theirs>
double compare_values(const Ours& ours, const Theirs& theirs, const recon::FitReports& reports,
                      int terms) {
  constexpr double margin = 100;
  const double rounding = static_cast<double>(std::numeric_limits<Scalar>::epsilon());
  double worst = 0;
  for (std::size_t t = 0; t < reports.size(); ++t) {
    const recon::FitReport& report = reports[t];
    if (report.status != recon::FitStatus::full) continue;
    const double difference =
        std::abs(static_cast<double>(ours[t]) - static_cast<double>(theirs[t]));
    const double tolerance = margin * terms * rounding /
                             static_cast<double>(report.smallest_pivot) *
                             std::max(1.0, static_cast<double>(report.amplification));
    worst = std::isfinite(difference) ? std::max(worst, difference / tolerance) : differs_in_kind;
  }
  return worst;
}

}  // namespace recon_bench
