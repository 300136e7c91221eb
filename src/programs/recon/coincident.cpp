#include "coincident.hpp"

#include <algorithm>
#include <numeric>

#include "recon/points/point_cloud.hpp"

namespace recon::program {

Coincidence count_coincident(const Particles& particles) {
  const PointCloud<double> cloud(particles.positions(), "particles", particles.domain);
  std::vector<std::uint32_t> order(cloud.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto compare = [&](std::uint32_t a, std::uint32_t b) {
    for (int d = 0; d < cloud.dimension(); ++d)
      if (cloud(a, d) != cloud(b, d)) return cloud(a, d) < cloud(b, d) ? -1 : 1;
    return 0;
  };
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return compare(a, b) < 0; });
  Coincidence found;
  for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    while (end < order.size() && compare(order[begin], order[end]) == 0) ++end;
    if (end - begin == 1) continue;
    ++found.places;
    found.particles += end - begin;
  }
  return found;
}

}  // namespace recon::program
