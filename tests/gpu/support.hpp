// The step of a GPU in loops on the processor, and how far its particles are from others.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include "cuda/host.hpp"
#include "gpu/step_on.hpp"
#include "mpm/support.hpp"

namespace recon::mpm::test {

template <int D>
using StepOnHost = StepOn<cuda::Host, D>;

template <int D>
std::unique_ptr<DeviceStep<D>> make_on_host(Plan<D>&& plan) {
  return std::make_unique<StepOnHost<D>>(std::make_shared<cuda::Host>(), std::move(plan));
}

// The largest difference of two states in any array, as a part of the largest number in the array
// of either; arrays that are less than `small` everywhere are compared with that.
template <int D>
double difference(const Problem<D>& problem, const State<D>& a, const State<D>& b,
                  std::string* of = nullptr, double small = 1e-12) {
  double most = 0;
  const Kept kept = problem.kept();
  a.particles.arrays(kept, [&]<class T>(const ParticleArray& array, const std::vector<T>& mine) {
    b.particles.arrays(kept, [&]<class U>(const ParticleArray& other, const std::vector<U>& its) {
      if constexpr (std::is_same_v<T, U>) {
        if (std::string(array.name) != other.name) return;
        ASSERT_EQ(mine.size(), its.size());
        using Number = std::conditional_t<std::is_same_v<T, std::int32_t>, std::int32_t, double>;
        const auto* const one = reinterpret_cast<const Number*>(mine.data());
        const auto* const two = reinterpret_cast<const Number*>(its.data());
        double largest = small, off = 0;
        for (std::size_t i = 0; i < mine.size() * sizeof(T) / sizeof(Number); ++i) {
          const double x = one[i], y = two[i];
          largest = std::max({largest, std::abs(x), std::abs(y)});
          off = std::isnan(x - y) ? std::numeric_limits<double>::infinity()
                                  : std::max(off, std::abs(x - y));
        }
        if (off / largest > most) {
          most = off / largest;
          if (of) *of = array.name;
        }
      }
    });
  });
  return most;
}

}  // namespace recon::mpm::test
