// Rows of neighbours: the functors that write them, one thread for each target.
#pragma once

#include "cuda/search.hpp"

namespace recon::cuda {

// Of all targets, in the order in which they were sorted. Entry e of row t, offsets[t] <= e <
// offsets[t + 1], is a place, and in periodic domains a shift, the lowest 24 bits of a key. The
// support is 0 where the row could not be found.
template <class T>
struct Rows {
  std::int64_t* offsets;
  std::uint32_t *places, *shifts;
  T* support;
};

// places[e] and shifts[e] of a key.
template <bool periodic, class T>
RECON_DEVICE void write_key(const Rows<T>& rows, std::int64_t e, KeyOf<periodic> key) {
  rows.places[e] = detail::NeighbourKey<periodic>::index(key);
  if constexpr (periodic) rows.shifts[e] = static_cast<std::uint32_t>(key & 0xFFFFFFu);
}

// The k nearest, with k <= room; for larger k the rows of `far` are what is worked in.
template <int D, class T, bool periodic, int room>
struct FindNearest {
  using Key = KeyOf<periodic>;
  CloudView<D, T> cloud;
  const T* targets;
  int k, reach;
  double factor;
  Rows<T> rows;
  Trouble* trouble;
  T* far_distance2 = nullptr;  // k for each target
  Key* far_key = nullptr;

  RECON_DEVICE void operator()(std::size_t t) const {
    if constexpr (room > 0) {
      T distance2[room];
      Key key[room];
      find(t, Best<T, Key>{distance2, key, k});
    } else {
      const std::size_t first = t * static_cast<std::size_t>(k);
      find(t, Best<T, Key>{far_distance2 + first, far_key + first, k});
    }
  }

 private:
  RECON_DEVICE void find(std::size_t t, Best<T, Key> best) const {
    T x[D];
    for (int d = 0; d < D; ++d) x[d] = targets[t * D + d];
    const auto first = static_cast<std::int64_t>(t) * k;
    if (!find_nearest<periodic>(cloud, x, reach, best)) {
      if (best.full()) keep_least(&trouble->shift, static_cast<std::uint32_t>(t));
      for (int i = 0; i < k; ++i) write_key<periodic>(rows, first + i, Key{0});
      rows.support[t] = k == 0 ? cloud.layout->spacing : T(0);
      return;
    }
    const T farthest = k == 0 ? T(0) : std::sqrt(best.worst());
    sort_keys(best.key, k);
    for (int i = 0; i < k; ++i) write_key<periodic>(rows, first + i, best.key[i]);
    rows.support[t] = k == 0 ? cloud.layout->spacing : support_of(x, farthest, t);
  }

  RECON_DEVICE T support_of(const T* x, T farthest, std::size_t t) const {
    if (!(farthest * farthest >= std::numeric_limits<T>::min())) {
      // All are at one place: the nearest that is not.
      T distance2;
      std::uint32_t key;
      Best<T, std::uint32_t> next{&distance2, &key, 1, std::numeric_limits<T>::min()};
      Around<D, T>(cloud, x).nearest(reach, Named<false>{}, next);
      return next.full() ? std::sqrt(distance2) : cloud.layout->spacing;
    }
    const T rho = static_cast<T>(factor * static_cast<double>(farthest));
    if (rho - rho == T(0)) return rho;
    keep_least(&trouble->support, static_cast<std::uint32_t>(t));
    return 0;
  }
};

// How many are within rho; offsets[t] is that number.
template <int D, class T, bool periodic>
struct CountWithin {
  CloudView<D, T> cloud;
  const T* targets;
  T rho, far;
  Rows<T> rows;
  Trouble* trouble;

  RECON_DEVICE void operator()(std::size_t t) const {
    T x[D];
    for (int d = 0; d < D; ++d) x[d] = targets[t * D + d];
    std::int64_t count = 0;
    const bool found = find_within<periodic>(cloud, x, rho, far, [&](KeyOf<periodic>) { ++count; });
    if (!found) keep_least(&trouble->shift, static_cast<std::uint32_t>(t));
    rows.offsets[t] = found ? count : 0;
    rows.support[t] = found ? rho : T(0);
  }
};

// Writes them behind offsets[t].
template <int D, class T, bool periodic>
struct FindWithin {
  CloudView<D, T> cloud;
  const T* targets;
  T rho, far;
  Rows<T> rows;

  RECON_DEVICE void operator()(std::size_t t) const {
    const std::int64_t first = rows.offsets[t], end = rows.offsets[t + 1];
    if (first == end) return;
    T x[D];
    for (int d = 0; d < D; ++d) x[d] = targets[t * D + d];
    std::int64_t e = first;
    find_within<periodic>(cloud, x, rho, far,
                          [&](KeyOf<periodic> key) { write_key<periodic>(rows, e++, key); });
    if constexpr (periodic) {
      // By place and shift: one image after another is in order.
      for (std::int64_t i = first + 1; i < end; ++i) {
        const std::uint32_t place = rows.places[i], shift = rows.shifts[i];
        std::int64_t at = i;
        for (; at > first && (rows.places[at - 1] > place ||
                              (rows.places[at - 1] == place && rows.shifts[at - 1] > shift));
             --at) {
          rows.places[at] = rows.places[at - 1];
          rows.shifts[at] = rows.shifts[at - 1];
        }
        rows.places[at] = place;
        rows.shifts[at] = shift;
      }
    }
  }
};

// offsets[t] = t k.
struct EqualRows {
  std::int64_t* offsets;
  std::int64_t k;
  RECON_DEVICE void operator()(std::size_t t) const {
    offsets[t] = static_cast<std::int64_t>(t) * k;
  }
};

// The number of neighbours of a target, from counts.
struct CountOf {
  const std::int64_t* counts;
  RECON_DEVICE std::int64_t operator()(std::size_t t) const { return counts[t]; }
};
struct Larger {
  template <class T>
  RECON_DEVICE T operator()(T a, T b) const {
    return most_of(a, b);
  }
};

// Says so, and leaves all rows empty, where there are more entries or longer rows than there is
// memory for. Run for 0 <= t <= targets; `total` is a copy of the last offset.
struct KeepToRoom {
  std::int64_t* offsets;
  const std::int64_t *total, *longest;
  std::int64_t most_entries, most_in_a_row;
  Trouble* trouble;
  RECON_DEVICE void operator()(std::size_t t) const {
    if (*total <= most_entries && *longest <= most_in_a_row) return;
    if (t == 0) keep_least(&trouble->room, 0);
    offsets[t] = 0;
  }
};
struct CopyOne {
  const std::int64_t* from;
  std::int64_t* to;
  RECON_DEVICE void operator()(std::size_t) const { *to = *from; }
};
struct SetOne {
  std::int64_t* to;
  std::int64_t value;
  RECON_DEVICE void operator()(std::size_t) const { *to = value; }
};

}  // namespace recon::cuda
