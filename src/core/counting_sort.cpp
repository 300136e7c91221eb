#include "core/counting_sort.hpp"

#include <algorithm>
#include <utility>

#include "recon/core/parallel.hpp"

namespace recon::detail {

void CountingSort::sort(std::size_t key_count, int threads) {
  constexpr std::size_t numbers_per_bucket = 4096, most_buckets = 1024;
  constexpr std::size_t least_chunk = 16384, most_chunks = 256;
  const std::size_t n = key_.size();
  first_.resize(key_count + 1);
  if (key_count == 0) {
    order_.resize(n);
    return;
  }

  const std::size_t wanted = std::clamp<std::size_t>(n / numbers_per_bucket, 1, most_buckets);
  int shift = 0;
  while (((key_count - 1) >> shift) >= wanted) ++shift;
  const std::size_t buckets = ((key_count - 1) >> shift) + 1;
  const std::size_t chunk = std::max(least_chunk, (n + most_chunks - 1) / most_chunks);
  const std::size_t chunks = std::max<std::size_t>(1, (n + chunk - 1) / chunk);

  // next_[c * buckets + b]: how many numbers of chunk c go to bucket b, then where the next one
  // goes.
  next_.assign(chunks * buckets, 0u);
  recon::parallel_blocks(n, chunk, threads, [&](std::size_t begin, std::size_t end) {
    std::uint32_t* const count = next_.data() + begin / chunk * buckets;
    for (std::size_t i = begin; i < end; ++i) ++count[key_[i] >> shift];
  });
  bucket_begin_.resize(buckets + 1);
  std::uint32_t total = 0;
  for (std::size_t b = 0; b < buckets; ++b) {
    bucket_begin_[b] = total;
    for (std::size_t c = 0; c < chunks; ++c) {
      const std::uint32_t here = next_[c * buckets + b];
      next_[c * buckets + b] = total;
      total += here;
    }
  }
  bucket_begin_[buckets] = total;

  rough_.resize(n);
  recon::parallel_blocks(n, chunk, threads, [&](std::size_t begin, std::size_t end) {
    std::uint32_t* const place = next_.data() + begin / chunk * buckets;
    for (std::size_t i = begin; i < end; ++i)
      rough_[place[key_[i] >> shift]++] = {key_[i], static_cast<std::uint32_t>(i)};
  });

  std::swap(order_, key_);  // the keys have gone along with the numbers
  recon::parallel_blocks(buckets, 1, threads, [&](std::size_t bucket, std::size_t) {
    const std::size_t first_key = bucket << shift;
    const std::size_t end_key = std::min(key_count, (bucket + 1) << shift);
    const std::uint32_t begin = bucket_begin_[bucket], end = bucket_begin_[bucket + 1];
    std::uint32_t* const place = first_.data();
    std::fill(place + first_key, place + end_key, 0u);
    for (std::uint32_t p = begin; p < end; ++p) ++place[rough_[p].key];
    std::uint32_t at = begin;
    for (std::size_t k = first_key; k < end_key; ++k) {
      const std::uint32_t here = place[k];
      place[k] = at;
      at += here;
    }
    for (std::uint32_t p = begin; p < end; ++p) order_[place[rough_[p].key]++] = rough_[p].number;
    // Each place is now that of the next key.
    for (std::size_t k = end_key; k-- > first_key + 1;) place[k] = place[k - 1];
    place[first_key] = begin;
  });
  first_[key_count] = static_cast<std::uint32_t>(n);
}

}  // namespace recon::detail
