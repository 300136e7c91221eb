// Points sorted by a key (the number of a cell), with their coordinates, in parallel.
//
// Two passes of a counting sort: first into buckets of consecutive keys that fit the cache, then
// each bucket by itself. So no pass writes to more than about a thousand places at a time, however
// many points there are. Points of equal key stay in the order of their indices. Blocks depend on
// the number of points alone: the result does not depend on the number of threads. Cost O(n +
// keys).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "recon/core/parallel.hpp"
#include "recon/neighbourhood/neighbour_list.hpp"
#include "recon/points/point_cloud.hpp"

namespace recon::detail {

// Coordinates along each axis and the indices that the points had. The arrays are longer than
// `size` by what a vector load may read beyond the end.
template <class S, int D>
struct SortedPoints {
  static constexpr std::size_t padding = 16;

  std::size_t size = 0;
  std::array<std::unique_ptr<S[]>, D> x;
  std::unique_ptr<ParticleIndex[]> index;

  SortedPoints() = default;
  // Not initialised but for the padding: the threads that write the pages first shall get them.
  explicit SortedPoints(std::size_t count)
      : size(count), index(new ParticleIndex[count + padding]) {
    std::fill_n(index.get() + count, padding, ParticleIndex{0});
    for (auto& axis : x) {
      axis.reset(new S[count + padding]);
      std::fill_n(axis.get() + count, padding, S(0));
    }
  }

  void put(std::size_t at, const std::array<S, D>& point, ParticleIndex i) {
    for (int d = 0; d < D; ++d) x[d][at] = point[d];
    index[at] = i;
  }
  std::array<S, D> point(std::size_t at) const {
    std::array<S, D> point;
    for (int d = 0; d < D; ++d) point[d] = x[d][at];
    return point;
  }
};

// key(point) < keys < 2^32. Unless null, first[q] becomes the place of the first point whose key
// is q or larger, for q from 0 to keys.
template <int D, class S, class Key>
SortedPoints<S, D> sort_by_key(const PointCloud<S>& cloud, std::size_t keys, const Key& key,
                               int threads, ParticleIndex* first) {
  constexpr std::size_t points_per_bucket = 4096, most_buckets = 1024;
  const std::size_t n = cloud.size();
  const std::size_t wanted = std::clamp<std::size_t>(n / points_per_bucket, 1, most_buckets);
  int shift = 0;
  while (((keys - 1) >> shift) >= wanted) ++shift;
  const std::size_t buckets = ((keys - 1) >> shift) + 1;
  const std::size_t chunk = std::max<std::size_t>(16384, (n + 255) / 256);
  const std::size_t chunks = std::max<std::size_t>(1, (n + chunk - 1) / chunk);

  // next[c * buckets + b]: how many points of chunk c go to bucket b, then where the next one goes.
  std::vector<ParticleIndex> next(chunks * buckets);
  const std::unique_ptr<std::uint32_t[]> key_of(new std::uint32_t[n]);
  recon::parallel_blocks(n, chunk, threads, [&](std::size_t begin, std::size_t end) {
    ParticleIndex* const count = next.data() + begin / chunk * buckets;
    for (std::size_t i = begin; i < end; ++i) {
      key_of[i] = static_cast<std::uint32_t>(key(cloud.template point<D>(i)));
      ++count[key_of[i] >> shift];
    }
  });
  std::vector<ParticleIndex> bucket_begin(buckets + 1);
  ParticleIndex total = 0;
  for (std::size_t b = 0; b < buckets; ++b) {
    bucket_begin[b] = total;
    for (std::size_t c = 0; c < chunks; ++c) {
      const ParticleIndex here = next[c * buckets + b];
      next[c * buckets + b] = total;
      total += here;
    }
  }
  bucket_begin[buckets] = total;

  SortedPoints<S, D> rough(n), sorted(n);
  const std::unique_ptr<std::uint32_t[]> rough_key(new std::uint32_t[n]);
  recon::parallel_blocks(n, chunk, threads, [&](std::size_t begin, std::size_t end) {
    ParticleIndex* const place = next.data() + begin / chunk * buckets;
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t at = place[key_of[i] >> shift]++;
      rough.put(at, cloud.template point<D>(i), static_cast<ParticleIndex>(i));
      rough_key[at] = key_of[i];
    }
  });
  recon::parallel_blocks(buckets, 1, threads, [&](std::size_t bucket, std::size_t) {
    const std::size_t first_key = bucket << shift;
    const std::size_t end_key = std::min(keys, (bucket + 1) << shift);
    const std::size_t begin = bucket_begin[bucket], end = bucket_begin[bucket + 1];
    std::vector<ParticleIndex> place(end_key - first_key);
    for (std::size_t p = begin; p < end; ++p) ++place[rough_key[p] - first_key];
    ParticleIndex at = bucket_begin[bucket];
    for (ParticleIndex& q : place) {
      const ParticleIndex here = q;
      q = at;
      at += here;
    }
    if (first != nullptr) std::copy(place.begin(), place.end(), first + first_key);
    for (std::size_t p = begin; p < end; ++p)
      sorted.put(place[rough_key[p] - first_key]++, rough.point(p), rough.index[p]);
  });
  if (first != nullptr) first[keys] = static_cast<ParticleIndex>(n);
  return sorted;
}

}  // namespace recon::detail
