#include "kernel_sum.hpp"

#include <cmath>
#include <numbers>

#include "recon/core/parallel.hpp"

namespace recon::program {

namespace {

// integral of w(q) q^power over 0 <= q <= 1: Gauss-Legendre with four points in 600 intervals,
// whose borders are among them the knots of the B-splines.
double radial_moment(const WeightFunction& weight, int power) {
  constexpr int intervals = 600;
  constexpr std::array<double, 4> place{-0.86113631159405258, -0.33998104358485626,
                                        0.33998104358485626, 0.86113631159405258};
  constexpr std::array<double, 4> share{0.34785484513745386, 0.65214515486254614,
                                        0.65214515486254614, 0.34785484513745386};
  double sum = 0;
  for (int i = 0; i < intervals; ++i) {
    std::array<double, 4> q, w;
    for (std::size_t g = 0; g < 4; ++g) q[g] = (i + 0.5 + 0.5 * place[g]) / intervals;
    weight.evaluate(q.data(), w.data(), nullptr, 4);
    for (std::size_t g = 0; g < 4; ++g)
      sum += share[g] / (2 * intervals) * w[g] * std::pow(q[g], power);
  }
  return sum;
}

}  // namespace

double weight_integral(const WeightFunction& weight, WeightForm form, int dimension) {
  if (form == WeightForm::tensor_product) return std::pow(2 * radial_moment(weight, 0), dimension);
  constexpr std::array<double, max_dimension> unit_sphere{2, 2 * std::numbers::pi,
                                                          4 * std::numbers::pi};
  return unit_sphere[dimension - 1] * radial_moment(weight, dimension - 1);
}

KernelSum::KernelSum(const PointsView<double>& particles, const PeriodicDomain<double>& domain,
                     const WeightFunction& weight, WeightForm form, int threads)
    : particles_(particles, "particles", domain),
      domain_(domain),
      weight_(weight),
      form_(form),
      threads_(threads),
      integral_(weight_integral(weight, form, particles.dimension())) {}

std::vector<double> KernelSum::at(const PointsView<double>& targets,
                                  const NeighbourList<double>& list,
                                  std::span<const double> amounts) const {
  const PointCloud<double> wrapped(targets, "targets", domain_);
  std::vector<double> sums(wrapped.size());
  parallel_blocks(wrapped.size(), 256, threads_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) sums[t] = kernel_sum(wrapped, t, list, amounts);
  });
  return sums;
}

double KernelSum::kernel_sum(const PointCloud<double>& targets, std::size_t target,
                             const NeighbourList<double>& list,
                             std::span<const double> amounts) const {
  const double support = list.support[target];
  const int dimension = particles_.dimension();
  double sum = 0;
  for (std::int64_t e = list.offsets[target]; e < list.offsets[target + 1]; ++e) {
    const std::size_t entry = static_cast<std::size_t>(e);
    const ParticleIndex p = list.indices[entry];
    std::array<double, max_dimension> q{}, w{1, 1, 1};
    double square = 0;
    for (int d = 0; d < dimension; ++d) {
      const double shift = list.shifts.empty() ? 0 : list.shifts[entry][d] * domain_.period(d);
      q[d] = std::abs(particles_(p, d) + shift - targets(target, d)) / support;
      square += q[d] * q[d];
    }
    if (form_ == WeightForm::tensor_product) {
      weight_.evaluate(q.data(), w.data(), nullptr, static_cast<std::size_t>(dimension));
    } else {
      q[0] = std::sqrt(square);
      weight_.evaluate(q.data(), w.data(), nullptr, 1);
    }
    sum += amounts[p] * w[0] * w[1] * w[2];
  }
  return sum / (integral_ * std::pow(support, dimension));
}

}  // namespace recon::program
