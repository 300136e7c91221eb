// The supports of pairs under the rules PairRadii and PairEllipsoids of find_neighbours.hpp.
#pragma once

#include <algorithm>

#include "recon/core/parallel.hpp"
#include "recon/neighbourhood/find_neighbours.hpp"

namespace recon::detail {

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

// The support tensor of a pair.
template <int D>
SymmetricTensor<D> pair_tensor(const PairEllipsoids& rule, std::size_t target,
                               std::size_t particle) {
  const SymmetricTensor<D> of_particle = tensor_at<D>(rule.particles, particle);
  if (rule.support == PairSupport::particle) return of_particle;
  return (of_particle + tensor_at<D>(rule.targets, target)) * 0.5;
}

// The support that is the largest along each axis, of all that may be that of a pair: half the
// edges of a box, that of the particles where a mean is taken of tensors. 0 for rules without
// pairs.
template <int D>
std::array<double, D> largest_pair_support(const NeighbourRule& rule) {
  std::array<double, D> largest{};
  if (const auto* radii = std::get_if<PairRadii>(&rule)) {
    double radius = 0;
    for (const double of_particle : radii->particles) radius = std::max(radius, of_particle);
    for (const double of_target : radii->targets) radius = std::max(radius, of_target);
    largest.fill(radius);
  } else if (const auto* ellipsoids = std::get_if<PairEllipsoids>(&rule)) {
    for (std::size_t p = 0; p < ellipsoids->particles.size(); ++p) {
      const auto half = tensor_at<D>(ellipsoids->particles, p).half_edges(false);
      for (int d = 0; d < D; ++d) largest[d] = std::max(largest[d], half[d]);
    }
  }
  return largest;
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

// Completes a list by the tensors of a rule of ellipsoids, and by the largest half axes.
template <class Scalar>
void add_support_tensors(const Ellipsoids& rule, int dimension, int threads,
                         NeighbourList<Scalar>& list);
template <class Scalar>
void add_support_tensors(const PairEllipsoids& rule, int dimension, int threads,
                         NeighbourList<Scalar>& list);

// Completes a list of neighbours found under this rule by what supports they have.
template <class Scalar>
void add_supports(const NeighbourRule& rule, int dimension, int threads,
                  NeighbourList<Scalar>& list) {
  if (const auto* radii = std::get_if<PairRadii>(&rule)) add_pair_supports(*radii, threads, list);
  if (const auto* ellipsoids = std::get_if<Ellipsoids>(&rule))
    add_support_tensors(*ellipsoids, dimension, threads, list);
  if (const auto* pairs = std::get_if<PairEllipsoids>(&rule))
    add_support_tensors(*pairs, dimension, threads, list);
}

}  // namespace recon::detail
