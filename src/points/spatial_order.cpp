#include "recon/points/spatial_order.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "recon/core/parallel.hpp"

namespace recon {
namespace {

constexpr std::size_t points_per_cell = 4;
constexpr std::size_t points_per_block = 16384;

// The bits of x with dimension - 1 zeros after each.
std::uint32_t spread(std::uint32_t x, int dimension) {
  if (dimension == 1) return x;
  if (dimension == 2) {
    x = (x | x << 8) & 0x00FF00FFu;
    x = (x | x << 4) & 0x0F0F0F0Fu;
    x = (x | x << 2) & 0x33333333u;
    return (x | x << 1) & 0x55555555u;
  }
  x = (x | x << 16) & 0x030000FFu;
  x = (x | x << 8) & 0x0300F00Fu;
  x = (x | x << 4) & 0x030C30C3u;
  return (x | x << 2) & 0x09249249u;
}

}  // namespace

template <class Scalar>
std::vector<std::uint32_t> spatial_order(const PointCloud<Scalar>& points, int threads) {
  const std::size_t n = points.size();
  const int dimension = points.dimension();
  int bits = 0;  // per axis
  while (bits < 30 / dimension && (n >> (dimension * (bits + 1))) >= points_per_cell) ++bits;

  std::array<double, max_dimension> lower{}, scale{};
  for (int d = 0; d < dimension && n > 0; ++d) {
    lower[d] = static_cast<double>(points.box().lower[d]);
    const double extent = static_cast<double>(points.box().upper[d]) - lower[d];
    scale[d] = extent > 0 ? std::ldexp(1.0, bits) / extent : 0;
    if (!std::isfinite(scale[d])) scale[d] = 0;
  }
  const double last = std::ldexp(1.0, bits) - 1;
  std::vector<std::uint32_t> keys(n);
  parallel_blocks(n, points_per_block, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      std::uint32_t key = 0;
      for (int d = 0; d < dimension; ++d) {
        const double at = (static_cast<double>(points(i, d)) - lower[d]) * scale[d];
        key |= spread(static_cast<std::uint32_t>(std::clamp(at, 0.0, last)), dimension) << d;
      }
      keys[i] = key;
    }
  });

  std::vector<std::uint32_t> next((std::size_t{1} << (dimension * bits)) + 1, 0);
  for (const std::uint32_t key : keys) ++next[key + 1];
  for (std::size_t c = 1; c < next.size(); ++c) next[c] += next[c - 1];
  std::vector<std::uint32_t> order(n);
  for (std::size_t i = 0; i < n; ++i) order[next[keys[i]]++] = static_cast<std::uint32_t>(i);
  return order;
}

template <class Scalar>
bool is_spatially_ordered(const PointCloud<Scalar>& points) {
  constexpr std::size_t most_samples = 1000;
  constexpr double short_step = 4;  // mean spacings
  const std::size_t n = points.size();
  if (n < 2) return true;
  double log_volume = 0;
  int axes = 0;
  for (int d = 0; d < points.dimension(); ++d) {
    const auto extent = static_cast<double>(points.box().extent(d));
    if (!(extent > 0)) continue;
    log_volume += std::log(extent);
    ++axes;
  }
  if (axes == 0) return true;
  const double spacing = std::exp((log_volume - std::log(static_cast<double>(n))) / axes);
  const std::size_t stride = (n - 1 + most_samples - 1) / most_samples;
  std::size_t steps = 0, short_steps = 0;
  for (std::size_t i = 0; i + 1 < n; i += stride) {
    double square = 0;
    for (int d = 0; d < points.dimension(); ++d) {
      const double step =
          (static_cast<double>(points(i + 1, d)) - static_cast<double>(points(i, d))) / spacing;
      square += step * step;
    }
    ++steps;
    short_steps += square < short_step * short_step;
  }
  return 5 * short_steps >= 4 * steps;
}

template bool is_spatially_ordered(const PointCloud<float>&);
template bool is_spatially_ordered(const PointCloud<double>&);
template std::vector<std::uint32_t> spatial_order(const PointCloud<float>&, int);
template std::vector<std::uint32_t> spatial_order(const PointCloud<double>&, int);

}  // namespace recon
