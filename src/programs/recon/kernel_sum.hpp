// Sums over kernels: how much of something lies at a place, per volume.
//
//     s(x) = sum_p a_p W(x - x_p),   W(r) = w(q) / (c rho^D),   c = integral of w, unit support,
// with the amounts a_p of the particles (mass: density; 1: number density; volume: solid
// fraction), w(q) the weight of the reconstruction and rho the support radius of the target (Lucy
// 1977; Gingold and Monaghan 1977). W has a unit integral, so the integral of s over all space is
// the sum of the amounts. Images across periodic borders count. Near a wall or a free surface part
// of the support is empty, and s falls off over one support radius; it is not divided by the part
// that is filled.
#pragma once

#include <span>
#include <vector>

#include "recon/neighbourhood/neighbour_list.hpp"
#include "recon/points/domain.hpp"
#include "recon/points/point_cloud.hpp"
#include "recon/weights/weight.hpp"

namespace recon::program {

// Integral of the weight over the unit ball or, as a tensor product, the cube of half side 1.
double weight_integral(const WeightFunction& weight, WeightForm form, int dimension);

class KernelSum {
 public:
  KernelSum(const PointsView<double>& particles, const PeriodicDomain<double>& domain,
            const WeightFunction& weight, WeightForm form, int threads);

  // `list` has for each target all particles in its support.
  std::vector<double> at(const PointsView<double>& targets, const NeighbourList<double>& list,
                         std::span<const double> amounts) const;

  const PointCloud<double>& particles() const { return particles_; }

 private:
  double kernel_sum(const PointCloud<double>& targets, std::size_t target,
                    const NeighbourList<double>& list, std::span<const double> amounts) const;

  PointCloud<double> particles_;
  PeriodicDomain<double> domain_;
  WeightFunction weight_;
  WeightForm form_;
  int threads_;
  double integral_;
};

}  // namespace recon::program
