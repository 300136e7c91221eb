// Points in the order of cells: the functors that load, check, measure and sort them.
//
// Cells are those of neighbourhood/cells.hpp, of about three particles, in the same order; here
// their size is chosen by a thread, so that nobody waits for the box of the particles.
#pragma once

#include <array>
#include <limits>

#include "cuda/device_code.hpp"
#include "neighbourhood/cell_index.hpp"
#include "neighbourhood/cell_size.hpp"
#include "recon/cuda/view.hpp"

namespace recon::cuda {

inline constexpr double particles_per_cell = 3;

// What went wrong, first of all the first point for which it did; `none` where nothing has.
struct Trouble {
  std::uint32_t not_finite = none;  // a coordinate of this point
  std::uint32_t too_large = none;   // 0: squares of distances overflow
  std::uint32_t shift = none;       // this target needs a shift beyond 127
  std::uint32_t support = none;     // the support of this target is not finite
  std::uint32_t room = none;        // 0: there are more neighbours than there is memory for
};

struct Forget {
  Trouble* trouble;
  RECON_DEVICE void operator()(std::size_t) const { *trouble = Trouble{}; }
};

// Coordinates divided by `stretch` and wrapped into a periodic domain.
template <int D, class T>
struct Frame {
  bool periodic[D]{};
  T lower[D]{}, upper[D]{}, period[D]{};
  double stretch[D]{};

  RECON_DEVICE bool any_period() const {
    bool any = false;
    for (int d = 0; d < D; ++d) any = any || periodic[d];
    return any;
  }
  RECON_DEVICE T least_period() const {
    T least = std::numeric_limits<T>::max();
    for (int d = 0; d < D; ++d)
      if (periodic[d]) least = least_of(least, period[d]);
    return least;
  }
  // PeriodicDomain::wrap(), to the bit: nothing is fused.
  RECON_DEVICE T wrap(T x, int d) const {
    if (!periodic[d]) return x;
    const T turns = std::floor((x - lower[d]) / period[d]);
    T wrapped = x - plain_product(turns, period[d]);
    if (wrapped < lower[d]) wrapped = lower[d];
    if (wrapped >= upper[d]) wrapped = lower[d];
    return wrapped;
  }
  RECON_DEVICE T take(T x, int d) const {
    const T own = stretch[d] == 1 ? x : static_cast<T>(static_cast<double>(x) / stretch[d]);
    return wrap(own, d);
  }
};

template <int D, class T>
struct Load {
  Points<D, T> points;
  Frame<D, T> frame;
  T* to;  // [point][axis]
  Trouble* trouble;

  RECON_DEVICE void operator()(std::size_t i) const {
    for (int d = 0; d < D; ++d) {
      const T x =
          points
              .data[static_cast<std::ptrdiff_t>(i) * points.point_stride + d * points.axis_stride];
      const bool finite = x - x == T(0);
      if (!finite) keep_least(&trouble->not_finite, static_cast<std::uint32_t>(i));
      to[i * D + d] = finite ? frame.take(x, d) : x;
    }
  }
};

template <class T>
struct Extent {
  T lower[max_dimension]{}, upper[max_dimension]{};
};
template <int D, class T>
struct ExtentOf {
  const T* x;
  RECON_DEVICE Extent<T> operator()(std::size_t i) const {
    Extent<T> one;
    for (int d = 0; d < D; ++d) {
      const bool finite = x[i * D + d] - x[i * D + d] == T(0);
      one.lower[d] = one.upper[d] = finite ? x[i * D + d] : T(0);
    }
    return one;
  }
};
template <int D, class T>
struct JoinExtents {
  RECON_DEVICE Extent<T> operator()(Extent<T> a, const Extent<T>& b) const {
    for (int d = 0; d < D; ++d) {
      a.lower[d] = least_of(a.lower[d], b.lower[d]);
      a.upper[d] = most_of(a.upper[d], b.upper[d]);
    }
    return a;
  }
};

template <class T>
struct NoExtent {
  Extent<T>* to;
  RECON_DEVICE void operator()(std::size_t) const { *to = Extent<T>{}; }
};

// The cells of a cloud.
template <class T>
struct Layout {
  T box_lower[max_dimension]{}, box_upper[max_dimension]{};
  double lower[max_dimension]{}, upper[max_dimension]{};
  double size = 1, inverse = 1;
  std::int64_t counts[max_dimension]{1, 1, 1};
  T spacing = 1;  // mean_spacing()

  RECON_DEVICE std::int64_t cells() const { return counts[0] * counts[1] * counts[2]; }
  RECON_DEVICE std::int64_t cell(T x, int d) const {
    return detail::cell_on_axis(static_cast<double>(x), lower[d], inverse, counts[d]);
  }
};

template <int D, class T>
struct ChooseCells {
  const Extent<T>* box;
  std::size_t count;
  Frame<D, T> frame;
  Layout<T>* to;
  Trouble* trouble;

  struct Length {
    const Extent<T>* box;
    RECON_DEVICE constexpr double operator()(int d) const {
      return static_cast<double>(box->upper[d]) - static_cast<double>(box->lower[d]);
    }
  };
  struct LengthOrPeriod {
    Length length;
    Frame<D, T> frame;
    RECON_DEVICE constexpr double operator()(int d) const {
      return frame.periodic[d] ? static_cast<double>(frame.period[d])
                               : static_cast<double>(length.box->upper[d] - length.box->lower[d]);
    }
  };

  RECON_DEVICE void operator()(std::size_t) const {
    Layout<T> layout;
    T diagonal = 0;
    for (int d = 0; d < D; ++d) {
      layout.box_lower[d] = box->lower[d];
      layout.box_upper[d] = box->upper[d];
      layout.lower[d] = static_cast<double>(box->lower[d]);
      layout.upper[d] = static_cast<double>(box->upper[d]);
      const T farthest = most_of(std::abs(box->lower[d]), std::abs(box->upper[d]));
      diagonal += 4 * farthest * farthest;
    }
    const Length length{box};
    if (!(diagonal - diagonal == T(0))) {
      keep_least(&trouble->too_large, 0);  // one cell serves as well as any
    } else {
      const double size = most_of(detail::size_of_cells(count, D, particles_per_cell, length),
                                  4 * std::numeric_limits<double>::min());
      layout.size = detail::cover_with_cells(size, count, D, length, layout.counts);
      layout.inverse = 1 / layout.size;
      layout.spacing = detail::mean_spacing_of<T>(count, D, LengthOrPeriod{length, frame});
    }
    *to = layout;
  }
};

// The cell of each point, and its number.
template <int D, class T>
struct Key {
  const T* x;
  const Layout<T>* layout;
  std::uint32_t *key, *number;

  RECON_DEVICE void operator()(std::size_t i) const {
    std::int64_t at[max_dimension] = {0, 0, 0};
    for (int d = 0; d < D; ++d) at[d] = layout->cell(x[i * D + d], d);
    key[i] = static_cast<std::uint32_t>(detail::row_of_cells(layout->counts, at[1], at[2]) + at[0]);
    number[i] = static_cast<std::uint32_t>(i);
  }
};

template <int D, class T>
struct Permute {
  const T* from;
  const std::uint32_t* order;
  T* to;

  RECON_DEVICE void operator()(std::size_t i) const {
    for (int d = 0; d < D; ++d) to[i * D + d] = from[std::size_t{order[i]} * D + d];
  }
};

struct PlaceOf {
  const std::uint32_t* order;
  std::uint32_t* place;
  RECON_DEVICE void operator()(std::size_t i) const {
    place[order[i]] = static_cast<std::uint32_t>(i);
  }
};

// first[c] is the place of the first of `count` sorted keys that is c or larger, for 0 <= c <=
// buckets; to be run for 0 <= i <= count.
template <class Buckets>
struct FirstOfEach {
  const std::uint32_t* key;
  std::size_t count;
  Buckets buckets;
  std::uint32_t* first;

  RECON_DEVICE void operator()(std::size_t i) const {
    const std::int64_t from = i == 0 ? 0 : std::int64_t{key[i - 1]} + 1;
    const std::int64_t to = i == count ? buckets() : std::int64_t{key[i]};
    for (std::int64_t c = from; c <= to; ++c) first[c] = static_cast<std::uint32_t>(i);
  }
};
template <class T>
struct CellsOfLayout {
  const Layout<T>* layout;
  RECON_DEVICE std::int64_t operator()() const { return layout->cells(); }
};
struct Known {
  std::int64_t buckets;
  RECON_DEVICE std::int64_t operator()() const { return buckets; }
};

// The bits of numbers from 0 to `most`.
inline int bits_of(std::uint64_t most) {
  int bits = 1;
  while (bits < 32 && most >> bits > 0) ++bits;
  return bits;
}

}  // namespace recon::cuda
