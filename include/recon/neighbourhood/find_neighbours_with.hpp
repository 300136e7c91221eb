// find_neighbours with a search of your own: any model of NeighbourSearch.
//
// The search must hold the same particles as the cloud, under the same indices; find_neighbours.hpp
// says what the result is. The compiled find_neighbours is this template with the searches of
// recon, but for the cell grid, which treats many targets at a time. Targets are treated in blocks
// with buffers of their own, which are then joined in order: the number of threads cannot change
// the result.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "recon/core/parallel.hpp"
#include "recon/neighbourhood/find_neighbours.hpp"
#include "recon/neighbourhood/periodic_images.hpp"
#include "recon/neighbourhood/search.hpp"

namespace recon {

namespace detail {

// The k of a nearest rule; a negative one has become a large number.
inline void require_count(std::size_t k) {
  require(k >= 1, "k", k, "must be at least 1");
  require(k <= 0xFFFFFFFFu, "k", static_cast<std::int64_t>(k), "must be from 1 to 2^32 - 1");
}

// Throws InvalidArgument for values outside their range and numbers of radii that are not those of
// the targets and particles.
template <class Scalar>
void require_valid_rule(const NeighbourRule& rule, std::size_t targets, std::size_t particles) {
  const auto positive = [](double length) {  // in the scalar type of the points
    const auto rounded = static_cast<Scalar>(length);
    return rounded > 0 && std::isfinite(rounded) &&
           rounded * rounded >= std::numeric_limits<Scalar>::min();
  };
  const char* const length_rule =
      "must be positive and finite, and not so small that its square underflows";
  const auto require_radii = [&](std::span<const double> radii, const char* of, const char* one,
                                 std::size_t number, const char* number_rule) {
    require(radii.size() == number, of, radii.size(), number_rule);
    for (std::size_t i = 0; i < number; ++i)
      if (!positive(radii[i])) throw_invalid(one + std::to_string(i), radii[i], length_rule);
  };
  if (const auto* radius = std::get_if<Radius>(&rule)) {
    require(positive(radius->radius), "radius", radius->radius, length_rule);
  } else if (const auto* radii = std::get_if<Radii>(&rule)) {
    require_radii(radii->radii, "number of radii", "radius of target ", targets,
                  "must be the number of targets");
  } else if (const auto* pairs = std::get_if<PairRadii>(&rule)) {
    require(pairs->support >= PairSupport::particle && pairs->support <= PairSupport::larger,
            "support of pairs", static_cast<int>(pairs->support),
            "must be an enumerator of recon::PairSupport");
    require_radii(pairs->particles, "number of radii of particles", "radius of particle ",
                  particles, "must be the number of particles");
    const bool symmetric = pairs->support != PairSupport::particle;
    require_radii(pairs->targets, "number of radii of targets", "radius of target ",
                  symmetric ? targets : 0,
                  symmetric ? "must be the number of targets"
                            : "must be 0 where pairs have the support of the particle");
  } else if (const auto* nearest = std::get_if<Nearest>(&rule)) {
    require_count(nearest->k);
    require(nearest->factor > 1 && std::isfinite(nearest->factor), "factor", nearest->factor,
            "must be larger than 1 and finite");
  } else if (const auto* near_within = std::get_if<NearestWithin>(&rule)) {
    require_count(near_within->k);
    require(positive(near_within->radius), "radius", near_within->radius, length_rule);
  }
}

template <class Scalar>
void require_in_domain(const Box<Scalar>& box, const PeriodicDomain<Scalar>& domain,
                       const char* name) {
  for (int d = 0; d < box.dimension && !box.is_empty(); ++d) {
    if (!domain.periodic[d]) continue;
    require(box.lower[d] >= domain.lower[d], name, box.lower[d], "must lie in the periodic domain");
    require(box.upper[d] <= domain.upper[d], name, box.upper[d], "must lie in the periodic domain");
  }
}

// Throws InvalidArgument unless rule, clouds and domain are as find_neighbours.hpp asks for.
template <class Scalar>
void require_valid_question(const PointCloud<Scalar>& particles, const PointCloud<Scalar>& targets,
                            const NeighbourRule& rule, const PeriodicDomain<Scalar>& domain) {
  require(targets.dimension() == particles.dimension(), "dimension of the targets",
          targets.dimension(), "must be the dimension of the particles");
  require_valid_rule<Scalar>(rule, targets.size(), particles.size());
  domain.validate(particles.dimension());
  // Where all squared distances underflow, none is the nearest.
  Scalar extent = 0;
  for (int d = 0; d < particles.dimension() && particles.size() > 0; ++d)
    extent = std::max(extent, particles.box().extent(d));
  require(extent == 0 || extent * extent >= std::numeric_limits<Scalar>::min(),
          "extent of the particles", extent, "must not be so small that its square underflows");
  require_in_domain(particles.box(), domain, "particle coordinate");
  require_in_domain(targets.box(), domain, "target coordinate");
}

// (volume / particles)^(1 / axes) over the axes with an extent; 1 where there is none.
template <class Scalar>
Scalar mean_spacing(const PointCloud<Scalar>& particles, const PeriodicDomain<Scalar>& domain) {
  if (particles.size() == 0) return 1;
  double log_volume = 0;
  int axes = 0;
  for (int d = 0; d < particles.dimension(); ++d) {
    const auto extent =
        static_cast<double>(domain.periodic[d] ? domain.period(d) : particles.box().extent(d));
    if (!(extent > 0)) continue;
    log_volume += std::log(extent);
    ++axes;
  }
  if (axes == 0) return 1;
  return std::max(static_cast<Scalar>(std::exp(
                      (log_volume - std::log(static_cast<double>(particles.size()))) / axes)),
                  2 * std::sqrt(std::numeric_limits<Scalar>::min()));
}

// NeighbourList::support_factor of what the rule finds.
template <class Scalar>
Scalar support_factor(const NeighbourRule& rule) {
  const auto* nearest = std::get_if<Nearest>(&rule);
  return nearest ? static_cast<Scalar>(nearest->factor) : Scalar(0);
}

// The support radius of a pair.
template <class Scalar>
Scalar pair_radius(const PairRadii& rule, std::size_t target, std::size_t particle) {
  const double of_particle = rule.particles[particle];
  switch (rule.support) {
    case PairSupport::mean:
      return static_cast<Scalar>(of_particle / 2 + rule.targets[target] / 2);
    case PairSupport::larger:
      return static_cast<Scalar>(std::max(of_particle, rule.targets[target]));
    default:
      return static_cast<Scalar>(of_particle);
  }
}

// The radius of a target that has no neighbours.
template <class Scalar>
Scalar lone_radius(const PairRadii& rule, std::size_t target) {
  if (!rule.targets.empty()) return static_cast<Scalar>(rule.targets[target]);
  if (rule.particles.empty()) return 1;
  return static_cast<Scalar>(*std::max_element(rule.particles.begin(), rule.particles.end()));
}

// Completes a list by the supports of its pairs, and of its targets as the largest of them.
template <class Scalar>
void add_pair_supports(const PairRadii& rule, int threads, NeighbourList<Scalar>& list) {
  const std::size_t count = list.targets();
  list.support.resize(count);
  list.pair_support.resize(list.indices.size());
  const Scalar none = count > 0 && rule.targets.empty() ? lone_radius<Scalar>(rule, 0) : Scalar(0);
  recon::parallel_blocks(count, 256, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      Scalar largest = 0;
      for (std::int64_t e = list.offsets[t]; e < list.offsets[t + 1]; ++e) {
        list.pair_support[e] = pair_radius<Scalar>(rule, t, list.indices[e]);
        largest = std::max(largest, list.pair_support[e]);
      }
      list.support[t] = largest > 0 ? largest : none > 0 ? none : lone_radius<Scalar>(rule, t);
    }
  });
}

// Finds the neighbours of one target after another; has the buffers for that.
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
                   const NeighbourOptions& options, Scalar spacing)
      : search_(search),
        particles_(particles),
        targets_(targets),
        domain_(domain),
        options_(options),
        spacing_(spacing),
        cube_(options.shape == SupportShape::cube),
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
    if (!(largest_radius_ > 0) && !rule.particles.empty()) {
      largest_radius_ = *std::max_element(rule.particles.begin(), rule.particles.end());
      for (const double radius : rule.targets) largest_radius_ = std::max(largest_radius_, radius);
    }
    all_within(target, static_cast<Scalar>(largest_radius_));
    std::erase_if(entries_, [&](const Entry& entry) {
      const Scalar rho = pair_radius<Scalar>(rule, target, entry.index);
      if (!cube_) return !(entry.distance2 <= rho * rho);
      Point x = x_;
      for (int d = 0; d < D; ++d)
        if (domain_.periodic[d]) x[d] -= static_cast<Scalar>(entry.shift[d]) * domain_.period(d);
      return !in_cube(x, entry.index, rho);
    });
    return static_cast<Scalar>(largest_radius_);
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
    if (particles_.size() == 0) return rho;
    if (!domain_.any()) {
      add_within(x_, {}, rho);
      return rho;
    }
    const Scalar limit = cube_ ? corner(rho) : rho;
    typename PeriodicImages<Scalar, D>::Image image;
    for (images_.start(x_); images_.next(limit * limit, image);)
      add_within(image.x, image.shift, rho);
    std::sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) {
      return a.index != b.index ? a.index < b.index : a.shift < b.shift;
    });
    return rho;
  }

  void add_within(const Point& x, const ImageShift& shift, Scalar rho) {
    if (cube_) {
      Point lower, upper;
      for (int d = 0; d < D; ++d) {
        lower[d] = std::max(x[d] - reach(rho), -largest);
        upper[d] = std::min(x[d] + reach(rho), largest);
      }
      search_.in_box(lower, upper, found_);
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
  double largest_radius_ = 0;     // of PairRadii
  Scalar cube_limit_ = infinity;  // half edge of the cube that the k nearest must lie in
  std::size_t target_ = 0;
  Point x_{};
  PeriodicImages<Scalar, D> images_;
  std::vector<Neighbour<Scalar>> found_;
  std::vector<Entry> entries_;
};

}  // namespace detail

template <NeighbourSearch S>
NeighbourList<typename S::Scalar> find_neighbours_with(
    const S& search, const PointCloud<typename S::Scalar>& particles,
    const PointCloud<typename S::Scalar>& targets, const NeighbourRule& rule,
    const PeriodicDomain<typename S::Scalar>& domain = {}, const NeighbourOptions& options = {}) {
  using Scalar = typename S::Scalar;
  detail::require(particles.dimension() == S::dimension, "dimension of the particles",
                  particles.dimension(), "must be the dimension of the search");
  detail::require(search.size() == particles.size(), "particles in the search", search.size(),
                  "must be as many as in the cloud");
  detail::require_valid_question(particles, targets, rule, domain);

  struct Block {
    std::vector<ParticleIndex> indices;
    std::vector<ImageShift> shifts;
  };
  constexpr std::size_t block_size = 256;
  const std::size_t count = targets.size();
  std::vector<Block> blocks((count + block_size - 1) / block_size);
  const Scalar spacing = detail::mean_spacing(particles, domain);

  NeighbourList<Scalar> list;
  list.offsets.resize(count + 1);
  list.support.resize(count);
  parallel_blocks(count, block_size, options.threads, [&](std::size_t begin, std::size_t end) {
    detail::TargetNeighbours<S> neighbours(search, particles, targets, domain, options, spacing);
    Block& block = blocks[begin / block_size];
    for (std::size_t t = begin; t < end; ++t) {
      list.support[t] = std::visit([&](const auto& r) { return neighbours.find(t, r); }, rule);
      for (const auto& entry : neighbours.entries()) {
        block.indices.push_back(entry.index);
        if (domain.any()) block.shifts.push_back(entry.shift);
      }
      list.offsets[t + 1] = static_cast<std::int64_t>(neighbours.entries().size());
    }
  });

  for (std::size_t t = 0; t < count; ++t) list.offsets[t + 1] += list.offsets[t];
  list.indices.resize(static_cast<std::size_t>(list.offsets.back()));
  if (domain.any()) list.shifts.resize(list.indices.size());
  parallel_blocks(count, block_size, options.threads, [&](std::size_t begin, std::size_t) {
    const Block block = std::move(blocks[begin / block_size]);
    std::copy(block.indices.begin(), block.indices.end(),
              list.indices.begin() + list.offsets[begin]);
    std::copy(block.shifts.begin(), block.shifts.end(),
              list.shifts.begin() + (domain.any() ? list.offsets[begin] : 0));
  });
  list.support_factor = detail::support_factor<Scalar>(rule);
  if (const auto* pairs = std::get_if<PairRadii>(&rule))
    detail::add_pair_supports(*pairs, options.threads, list);
  return list;
}

}  // namespace recon
