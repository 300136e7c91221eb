#include "recon/points/point_cloud.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <type_traits>

#include "core/instantiate.hpp"
#include "recon/core/parallel.hpp"

namespace recon {
namespace {

using detail::coordinate_name;
using detail::require;

constexpr std::size_t points_per_block = 16384, most_blocks = 256, points_at_once = 512;

}  // namespace

template <class Scalar>
PointCloud<Scalar>::PointCloud(const PointsView<Scalar>& points, const char* name,
                               const PeriodicDomain<Scalar>& domain, int threads) {
  assign(points, name, domain, threads);
}

template <class Scalar>
void PointCloud<Scalar>::assign(const PointsView<Scalar>& points, const char* name,
                                const PeriodicDomain<Scalar>& domain, int threads) {
  dimension_ = points.dimension();
  size_ = points.size();
  box_ = Box<Scalar>::empty(dimension_);
  require(size_ < 0xFFFFFFFFu, name, size_, "must be fewer than 2^32 - 1 points");
  domain.validate(dimension_);
  coordinates_.resize(size_ * static_cast<std::size_t>(dimension_));
  std::array<Box<Scalar>, most_blocks> boxes;
  boxes.fill(box_);
  const std::size_t block = std::max(points_per_block, (size_ + most_blocks - 1) / most_blocks);
  parallel_blocks(size_, block, threads, [&](std::size_t begin, std::size_t end) {
    // Few enough that the axes after the first find them in the first cache.
    for (std::size_t first = begin; first < end; first += points_at_once)
      for (int d = 0; d < dimension_; ++d)
        copy_axis(points, first, std::min(end, first + points_at_once), d, name, domain,
                  boxes[begin / block]);
  });
  for (const Box<Scalar>& box : boxes)
    for (int d = 0; d < dimension_ && !box.is_empty(); ++d) {
      box_.add(d, box.lower[d]);
      box_.add(d, box.upper[d]);
    }
  // Distances are squared: a box whose diagonal overflows would make every comparison meaningless.
  Scalar diagonal = 0;
  for (int d = 0; d < dimension_ && !box_.is_empty(); ++d) {
    const Scalar size = std::max(std::abs(box_.lower[d]), std::abs(box_.upper[d]));
    diagonal += 4 * size * size;
  }
  require(std::isfinite(diagonal), name, diagonal,
          "must have coordinates whose squares can be represented");
}

template <class Scalar>
void PointCloud<Scalar>::copy_axis(const PointsView<Scalar>& points, std::size_t begin,
                                   std::size_t end, int d, const char* name,
                                   const PeriodicDomain<Scalar>& domain, Box<Scalar>& box) {
  const auto stride = static_cast<std::size_t>(dimension_);
  Scalar* const to = coordinates_.data() + d;
  bool finite = true;
  Scalar lower = points(begin, d), upper = lower;
  for (std::size_t i = begin; i < end; ++i) {
    const Scalar x = points(i, d);
    finite &= std::abs(x) <= std::numeric_limits<Scalar>::max();
    lower = std::min(lower, x);
    upper = std::max(upper, x);
    to[i * stride] = x;
  }
  for (std::size_t i = begin; i < end && !finite; ++i)
    if (!std::isfinite(to[i * stride]))
      detail::throw_invalid(coordinate_name(i, d, name), to[i * stride], "must be finite");
  if (domain.periodic[d]) {
    lower = upper = domain.wrap(lower, d);
    for (std::size_t i = begin; i < end; ++i) {
      Scalar& x = to[i * stride];
      x = domain.wrap(x, d);
      lower = std::min(lower, x);
      upper = std::max(upper, x);
    }
  }
  box.add(d, lower);
  box.add(d, upper);
}

template <class Scalar>
void PointCloud<Scalar>::assign_permuted(const PointCloud& other,
                                         std::span<const std::uint32_t> order, int threads) {
  dimension_ = other.dimension_;
  size_ = order.size();
  box_ = other.box_;
  const auto stride = static_cast<std::size_t>(dimension_);
  coordinates_.resize(size_ * stride);
  const auto copy = [&]<std::size_t D>(std::integral_constant<std::size_t, D>) {
    const Scalar* const from = other.coordinates_.data();
    Scalar* const to = coordinates_.data();
    parallel_blocks(size_, points_per_block, threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        for (std::size_t d = 0; d < D; ++d) to[i * D + d] = from[std::size_t{order[i]} * D + d];
    });
  };
  if (dimension_ == 1) copy(std::integral_constant<std::size_t, 1>{});
  if (dimension_ == 2) copy(std::integral_constant<std::size_t, 2>{});
  if (dimension_ == 3) copy(std::integral_constant<std::size_t, 3>{});
}

template <class Scalar>
PointCloud<Scalar> PointCloud<Scalar>::permuted(std::span<const std::uint32_t> order,
                                                int threads) const {
  PointCloud out;
  out.assign_permuted(*this, order, threads);
  return out;
}

RECON_FLOAT(template class PointCloud<float>;)
template class PointCloud<double>;

}  // namespace recon
