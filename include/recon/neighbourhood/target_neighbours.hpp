// The neighbours of one target after another, with any model of NeighbourSearch: what each rule of
// find_neighbours.hpp asks of a search, over periodic images, with visibility and in cubes.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "recon/core/error.hpp"
#include "recon/neighbourhood/find_neighbours.hpp"
#include "recon/neighbourhood/pair_supports.hpp"
#include "recon/neighbourhood/periodic_images.hpp"
#include "recon/neighbourhood/search.hpp"

namespace recon::detail {

// Has the buffers for one target after another.
template <NeighbourSearch S>
class TargetNeighbours {
 public:
  using Scalar = typename S::Scalar;
  static constexpr int D = S::dimension;
  using Point = std::array<Scalar, D>;

  struct Entry {
    Scalar distance2;
    ParticleIndex index;
    ImageShift shift;
  };

  TargetNeighbours(const S& search, const PointCloud<Scalar>& particles,
                   const PointCloud<Scalar>& targets, const PeriodicDomain<Scalar>& domain,
                   const NeighbourOptions& options, Scalar spacing,
                   const std::array<double, D>& largest_pair = {})
      : search_(search),
        particles_(particles),
        targets_(targets),
        domain_(domain),
        options_(options),
        spacing_(spacing),
        cube_(options.shape == SupportShape::cube),
        largest_pair_(largest_pair),
        images_(domain, particles.box()) {}

  // The neighbours found by the latest call of the functions below.
  const std::vector<Entry>& entries() const { return entries_; }

  // Each returns the support radius.
  Scalar find(std::size_t target, const Radius& rule) {
    return all_within(target, static_cast<Scalar>(rule.radius));
  }
  Scalar find(std::size_t target, const Radii& rule) {
    return all_within(target, static_cast<Scalar>(rule.radii[target]));
  }
  // By going through all within the largest radius: for searches that know the particles only.
  Scalar find(std::size_t target, const PairRadii& rule) {
    const auto largest_radius = static_cast<Scalar>(largest_pair_[0]);
    all_within(target, largest_radius);
    std::erase_if(entries_, [&](const Entry& entry) {
      const Scalar rho = pair_radius<Scalar>(rule, target, entry.index);
      if (!cube_) return !(entry.distance2 <= rho * rho);
      Point x = x_;
      for (int d = 0; d < D; ++d)
        if (domain_.periodic[d]) x[d] -= static_cast<Scalar>(entry.shift[d]) * domain_.period(d);
      return !in_cube(x, entry.index, rho);
    });
    return largest_radius;
  }
  // The radius is 0 until add_supports() completes the list.
  Scalar find(std::size_t target, const Ellipsoids& rule) {
    const SymmetricTensor<D> tensor = tensor_at<D>(rule.tensors, target);
    const SymmetricTensor<D> inverse = tensor.inverse();
    all_in_ellipsoids(target, tensor.half_edges(cube_),
                      [&](ParticleIndex) -> const SymmetricTensor<D>& { return inverse; });
    return 0;
  }
  // By going through all in the box of the largest support, as for PairRadii.
  Scalar find(std::size_t target, const PairEllipsoids& rule) {
    std::array<double, D> half = largest_pair_;
    if (rule.support == PairSupport::mean) {
      const auto own = tensor_at<D>(rule.targets, target).half_edges(false);
      for (int d = 0; d < D; ++d) half[d] = (half[d] + own[d]) / 2;
    }
    all_in_ellipsoids(target, half, [&](ParticleIndex particle) {
      return pair_tensor<D>(rule, target, particle).inverse();
    });
    return 0;
  }
  Scalar find(std::size_t target, const NearestWithin& rule) {
    const auto rho = static_cast<Scalar>(rule.radius);
    start(target);
    cube_limit_ = cube_ ? rho : infinity;
    k_nearest(rule.k, cube_ ? corner(rho) : rho);
    return rho;
  }
  Scalar find(std::size_t target, const Nearest& rule) {
    start(target);
    cube_limit_ = infinity;
    k_nearest(rule.k, largest);
    if (entries_.empty()) return spacing_;
    const Scalar farthest = cube_ ? farthest_along_axis() : std::sqrt(entries_.back().distance2);
    // Particles that are closer than that count as being at one place.
    if (!(farthest * farthest >= std::numeric_limits<Scalar>::min())) return next_distance();
    const Scalar rho = static_cast<Scalar>(rule.factor * static_cast<double>(farthest));
    require(std::isfinite(rho), "factor", rule.factor,
            "must give supports that can be represented");
    return rho;
  }

 private:
  static constexpr Scalar infinity = std::numeric_limits<Scalar>::infinity();
  static constexpr Scalar largest = std::numeric_limits<Scalar>::max();

  // A radius that reaches the corners of the cube.
  static Scalar corner(Scalar rho) { return std::min(reach(rho * std::sqrt(Scalar(D))), largest); }

  void start(std::size_t target) {
    target_ = target;
    x_ = targets_.template point<D>(target);
    entries_.clear();
  }

  bool visible(ParticleIndex particle) const {
    return !options_.visible || options_.visible(target_, particle);
  }

  // Whether |x - x_p| <= rho on every axis.
  bool in_cube(const Point& x, ParticleIndex particle, Scalar rho) const {
    for (int d = 0; d < D; ++d)
      if (std::abs(x[d] - particles_(particle, d)) > rho) return false;
    return true;
  }

  Scalar all_within(std::size_t target, Scalar rho) {
    start(target);
    const Scalar limit = cube_ ? corner(rho) : rho;
    over_images(limit * limit,
                [&](const Point& x, const ImageShift& shift) { add_within(x, shift, rho); });
    return rho;
  }

  // All particles p with |inverse_of(p) (x_p - x)| <= 1, which must lie in the box around x with
  // these half edges.
  template <class InverseOf>
  void all_in_ellipsoids(std::size_t target, const std::array<double, D>& half_edges,
                         const InverseOf& inverse_of) {
    start(target);
    Point half;
    Scalar limit2 = 0;
    for (int d = 0; d < D; ++d) {
      half[d] = static_cast<Scalar>(half_edges[d]);
      limit2 += reach(half[d]) * reach(half[d]);
    }
    over_images(std::min(limit2, largest), [&](const Point& x, const ImageShift& shift) {
      find_in_box(x, half);
      for (const auto& near : found_)
        if (in_ellipsoid(inverse_of(near.index), x, near.index) && visible(near.index))
          entries_.push_back({near.distance2, near.index, shift});
    });
  }

  bool in_ellipsoid(const SymmetricTensor<D>& inverse, const Point& x,
                    ParticleIndex particle) const {
    std::array<double, D> offset;
    for (int d = 0; d < D; ++d) offset[d] = static_cast<double>(particles_(particle, d) - x[d]);
    double q2 = 0;
    for (const double along : inverse.times(offset))
      q2 = cube_ ? std::max(q2, along * along) : q2 + along * along;
    return q2 <= 1;
  }

  // Calls add(x - shift * period, shift) for all images that may be within a distance of the
  // particles, and sorts what it has added.
  template <class Add>
  void over_images(Scalar limit2, const Add& add) {
    if (particles_.size() == 0) return;
    if (!domain_.any()) return add(x_, ImageShift{});
    typename PeriodicImages<Scalar, D>::Image image;
    for (images_.start(x_); images_.next(limit2, image);) add(image.x, image.shift);
    std::sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) {
      return a.index != b.index ? a.index < b.index : a.shift < b.shift;
    });
  }

  // Into found_: what is in the box with these half edges around x.
  void find_in_box(const Point& x, const Point& half) {
    Point lower, upper;
    for (int d = 0; d < D; ++d) {
      lower[d] = std::max(x[d] - reach(half[d]), -largest);
      upper[d] = std::min(x[d] + reach(half[d]), largest);
    }
    search_.in_box(lower, upper, found_);
  }

  void add_within(const Point& x, const ImageShift& shift, Scalar rho) {
    if (cube_) {
      Point half;
      half.fill(rho);
      find_in_box(x, half);
    } else {
      search_.within(x, rho, found_);
    }
    for (const auto& near : found_)
      if ((!cube_ || in_cube(x, near.index, rho)) && visible(near.index))
        entries_.push_back({near.distance2, near.index, shift});
  }

  // The k nearest within the limit that pass the tests, over all images.
  void k_nearest(std::size_t k, Scalar limit) {
    if (particles_.size() == 0) return;
    if (!domain_.any()) {
      find_nearest(x_, k, limit);
      for (const auto& near : found_) entries_.push_back({near.distance2, near.index, {}});
      return;
    }
    typename PeriodicImages<Scalar, D>::Image image;
    for (images_.start(x_); images_.next(limit * limit, image);) {
      const bool all = find_nearest(image.x, k, limit);
      if (all && found_.empty() && limit == largest)
        break;  // no particle is visible, nor are its images
      for (const auto& near : found_) keep({near.distance2, near.index, image.shift}, k);
      if (entries_.size() == k)  // from now on only what is as near as the k-th
        limit = std::min(limit, reach(std::sqrt(entries_.front().distance2)));
    }
    std::sort(entries_.begin(), entries_.end(), before);
  }

  // Into found_: the k nearest to x within the limit that pass the tests. Asks for more and more
  // until there are k of them. True if no other particle is within the limit.
  bool find_nearest(const Point& x, std::size_t k, Scalar limit) {
    const bool tests = options_.visible || cube_limit_ < infinity;
    for (std::size_t ask = std::min(k, particles_.size());;
         ask = std::min(2 * ask, particles_.size())) {
      if (limit < largest)
        search_.nearest_within(x, ask, limit, found_);
      else
        search_.nearest(x, ask, found_);
      const bool all = found_.size() < ask || ask == particles_.size();
      if (tests)
        std::erase_if(found_, [&](const auto& near) {
          return (cube_limit_ < infinity && !in_cube(x, near.index, cube_limit_)) ||
                 !visible(near.index);
        });
      if (all || found_.size() >= k) {
        if (found_.size() > k) found_.resize(k);
        return all;
      }
    }
  }

  static bool before(const Entry& a, const Entry& b) {
    if (a.distance2 != b.distance2) return a.distance2 < b.distance2;
    return a.index != b.index ? a.index < b.index : a.shift < b.shift;
  }

  // Keeps entries_ as a heap of the k nearest so far, the farthest in front.
  void keep(const Entry& entry, std::size_t k) {
    if (entries_.size() == k) {
      if (!before(entry, entries_.front())) return;
      std::pop_heap(entries_.begin(), entries_.end(), before);
      entries_.pop_back();
    }
    entries_.push_back(entry);
    std::push_heap(entries_.begin(), entries_.end(), before);
  }

  Scalar farthest_along_axis() const {
    Scalar farthest = 0;
    for (const Entry& entry : entries_)
      for (int d = 0; d < D; ++d) {
        Scalar x = x_[d];
        if (domain_.periodic[d]) x -= static_cast<Scalar>(entry.shift[d]) * domain_.period(d);
        farthest = std::max(farthest, std::abs(x - particles_(entry.index, d)));
      }
    return farthest;
  }

  // Distance to the nearest particle that does not coincide with the target; else the mean spacing.
  Scalar next_distance() {
    for (std::size_t ask = 1;; ask = std::min(2 * ask, particles_.size())) {
      search_.nearest(x_, ask, found_);
      for (const auto& near : found_)
        if (near.distance2 >= std::numeric_limits<Scalar>::min()) return std::sqrt(near.distance2);
      if (ask >= particles_.size()) return spacing_;
    }
  }

  const S& search_;
  const PointCloud<Scalar>& particles_;
  const PointCloud<Scalar>& targets_;
  const PeriodicDomain<Scalar>& domain_;
  const NeighbourOptions& options_;
  const Scalar spacing_;
  const bool cube_;
  const std::array<double, D> largest_pair_;  // largest_pair_support()
  Scalar cube_limit_ = infinity;  // half edge of the cube that the k nearest must lie in
  std::size_t target_ = 0;
  Point x_{};
  PeriodicImages<Scalar, D> images_;
  std::vector<Neighbour<Scalar>> found_;
  std::vector<Entry> entries_;
};

}  // namespace recon::detail
