// The supports of pairs under the rule PairRadii of find_neighbours.hpp.
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

}  // namespace recon::detail
