// How every solver fills its FitReport.
#pragma once

#include <array>
#include <cstdint>

#include "recon/core/lanes.hpp"
#include "recon/local_solve/report.hpp"

namespace recon::detail {

// What a report says of a fit besides the terms that it kept.
struct FitNumbers {
  Solver solver = Solver::gram_schmidt;
  std::uint32_t neighbours = 0;
  float smallest_pivot = 0, amplification = 0, gradient_amplification = 0;
};

// The numbers of a MomentMatrix or RegularGramSchmidt of one target.
template <class Fit>
constexpr FitNumbers numbers_of(Solver solver, int neighbours, const Fit& fit) {
  return {solver, static_cast<std::uint32_t>(neighbours), to_float(fit.smallest_pivot()),
          to_float(fit.amplification()), to_float(fit.gradient_amplification())};
}

constexpr void set_numbers(const FitNumbers& numbers, FitReport& report) {
  report.solver = numbers.solver;
  report.neighbours = numbers.neighbours;
  report.smallest_pivot = numbers.smallest_pivot;
  report.amplification = numbers.amplification;
  report.gradient_amplification = numbers.gradient_amplification;
}

// How many independent directions there are within each degree of a basis.
using Kept = decltype(FitReport::kept);
template <class B>
constexpr Kept all_terms() {
  static_assert(B::degree <= FitReport::max_degree,
                "recon: the degree of the basis exceeds FitReport::max_degree");
  Kept kept{};
  for (int k = 0; k <= B::degree; ++k)
    kept[k] = static_cast<std::uint8_t>(B::begin(k + 1) - B::begin(k));
  return kept;
}

// FitReport::hessian_rank, as far as it follows from kept and gradient_rank: r directions need
// r (r + 1) / 2 terms of second degree.
constexpr std::uint8_t hessian_rank_of(const FitReport& report) {
  const int r = report.gradient_rank;
  return r > 0 && 2 * report.kept[2] >= r * (r + 1) ? report.gradient_rank : 0;
}

// The report on a fit that kept these terms of B, where degree `asked` was wanted. Derivatives
// count as resolved wherever there are terms for them.
template <class B>
constexpr FitReport report_of(const FitNumbers& numbers, const Kept& kept = all_terms<B>(),
                              int asked = B::degree) {
  constexpr Kept all = all_terms<B>();
  FitReport report;
  set_numbers(numbers, report);
  int rank = 0, degree = -1;
  bool complete = true;
  for (int k = 0; k <= B::degree; ++k) {
    rank += kept[k];
    complete = complete && kept[k] == all[k];
    if (complete) degree = k;
  }
  report.rank = static_cast<std::uint8_t>(rank);
  report.degree = static_cast<std::int8_t>(degree);
  report.status = degree == asked ? FitStatus::full
                  : degree >= 0   ? FitStatus::reduced
                                  : FitStatus::no_support;
  report.gradient_rank = B::degree >= 1 && rank > 0 ? B::dimension : 0;
  report.kept = kept;
  report.hessian_rank = hessian_rank_of(report);
  return report;
}

}  // namespace recon::detail
