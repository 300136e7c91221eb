// find_neighbours with a search of your own: any model of NeighbourSearch.
//
// The search must hold the same particles as the cloud, under the same indices; find_neighbours.hpp
// says what the result is. The compiled find_neighbours is this template with the searches of
// recon, but for the cell grid, which treats many targets at a time. Targets are treated in blocks
// with buffers of their own, which are then joined in order: the number of threads cannot change
// the result.
#pragma once

#include <algorithm>
#include <vector>

#include "recon/core/parallel.hpp"
#include "recon/core/progress.hpp"
#include "recon/neighbourhood/mean_spacing.hpp"
#include "recon/neighbourhood/question_checks.hpp"
#include "recon/neighbourhood/target_neighbours.hpp"

namespace recon {

namespace detail {

// NeighbourList::support_factor of what the rule finds.
template <class Scalar>
Scalar support_factor(const NeighbourRule& rule) {
  const auto* nearest = std::get_if<Nearest>(&rule);
  return nearest ? static_cast<Scalar>(nearest->factor) : Scalar(0);
}

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
  detail::require_valid_question(particles, targets, rule, domain, options.shape);

  struct Block {
    std::vector<ParticleIndex> indices;
    std::vector<ImageShift> shifts;
  };
  constexpr std::size_t block_size = 256;
  const std::size_t count = targets.size();
  std::vector<Block> blocks((count + block_size - 1) / block_size);
  const Scalar spacing = detail::mean_spacing(particles, domain);
  const auto largest_pair = detail::largest_pair_support<S::dimension>(rule);

  NeighbourList<Scalar> list;
  list.offsets.resize(count + 1);
  list.support.resize(count);
  const auto search_block = [&](std::size_t begin, std::size_t end) {
    detail::TargetNeighbours<S> neighbours(search, particles, targets, domain, options, spacing,
                                           largest_pair);
    Block& block = blocks[begin / block_size];
    for (std::size_t t = begin; t < end; ++t) {
      list.support[t] = std::visit([&](const auto& r) { return neighbours.find(t, r); }, rule);
      for (const auto& entry : neighbours.entries()) {
        block.indices.push_back(entry.index);
        if (domain.any()) block.shifts.push_back(entry.shift);
      }
      list.offsets[t + 1] = static_cast<std::int64_t>(neighbours.entries().size());
    }
  };
  parallel_blocks(count, block_size, options.threads, options.progress, search_block);

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
  detail::add_supports(rule, S::dimension, options.threads, list);
  return list;
}

}  // namespace recon
