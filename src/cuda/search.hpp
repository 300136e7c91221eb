// The neighbours of one target in the cells of a cloud, by one thread.
//
// What is found, and the order of it, is that of find_neighbours(): squared distances have the same
// bits, and equal ones are told apart by the place of the particle and the shift (NeighbourKey).
// Rows are listed by ascending place and shift. Cells are looked at in growing boxes about the
// target, rows of cells and parts of them that are too far are left out.
#pragma once

#include "cuda/sources_on.hpp"
#include "neighbourhood/neighbour_key.hpp"

namespace recon::cuda {

template <bool periodic>
using KeyOf = typename detail::NeighbourKey<periodic>::Key;

// The `most` least by (distance2, key), as a heap with the greatest in front. Distances below
// `least` are passed over, and so is what is no number.
template <class T, class Key>
struct Best {
  T* distance2;
  Key* key;
  int most;
  T least = 0;
  int size = 0;

  RECON_DEVICE bool full() const { return size == most; }
  RECON_DEVICE T worst() const { return distance2[0]; }

  RECON_DEVICE void see(T d2, Key k) {
    if (!(d2 >= least)) return;
    if (size < most) {
      int at = size++;
      for (; at > 0 && before((at - 1) / 2, d2, k); at = (at - 1) / 2) move((at - 1) / 2, at);
      distance2[at] = d2;
      key[at] = k;
      return;
    }
    if (!(d2 < distance2[0] || (d2 == distance2[0] && k < key[0]))) return;
    int at = 0;
    for (;;) {
      int child = 2 * at + 1;
      if (child >= most) break;
      if (child + 1 < most && before(child, distance2[child + 1], key[child + 1])) ++child;
      if (!(distance2[child] > d2 || (distance2[child] == d2 && key[child] > k))) break;
      move(child, at);
      at = child;
    }
    distance2[at] = d2;
    key[at] = k;
  }

 private:
  // Does entry i come before (d2, k)?
  RECON_DEVICE bool before(int i, T d2, Key k) const {
    return distance2[i] < d2 || (distance2[i] == d2 && key[i] < k);
  }
  RECON_DEVICE void move(int from, int to) {
    distance2[to] = distance2[from];
    key[to] = key[from];
  }
};

// Sorts keys in place: few, or nearly in order.
template <class Key>
RECON_DEVICE void sort_keys(Key* key, int count) {
  for (int i = 1; i < count; ++i) {
    const Key moved = key[i];
    int at = i;
    for (; at > 0 && key[at - 1] > moved; --at) key[at] = key[at - 1];
    key[at] = moved;
  }
}

// A search about one point, which may lie outside the particles.
template <int D, class T>
class Around {
  static constexpr double eps = std::numeric_limits<double>::epsilon();
  // Of a squared distance in T, against that of exact coordinates.
  static constexpr double rounding = 16 * static_cast<double>(std::numeric_limits<T>::epsilon());

 public:
  RECON_DEVICE Around(const CloudView<D, T>& cloud, const T* x) : cloud_(cloud), x_(x) {
    const Layout<T>& at = *cloud.layout;
    for (int d = 0; d < D; ++d) {
      const double size = std::abs(static_cast<double>(x[d]));
      margin_ = most_of(margin_, 16 * eps * (std::abs(at.lower[d]) + std::abs(at.upper[d]) + size));
    }
  }

  // Shows to `best` all particles that may be among the least; key_of(place) is what they are called.
  template <class Best, class Named>
  RECON_DEVICE void nearest(std::int64_t reach, const Named& key_of, Best& best) const {
    const Layout<T>& at = *cloud_.layout;
    std::int64_t base[max_dimension] = {0, 0, 0};
    for (int d = 0; d < D; ++d) base[d] = at.cell(x_[d], d);
    std::int64_t from[max_dimension] = {0, 0, 0}, to[max_dimension] = {0, 0, 0};
    std::int64_t was_from[max_dimension] = {0, 0, 0}, was_to[max_dimension] = {-1, -1, -1};
    const auto see = [&](std::uint32_t place, T d2) { best.see(d2, key_of(place)); };
    for (;; reach += 1 + reach / 4) {
      bool all = true;
      double edge = std::numeric_limits<double>::max();
      for (int d = 0; d < D; ++d) {
        from[d] = most_of<std::int64_t>(base[d] - reach, 0);
        to[d] = least_of<std::int64_t>(base[d] + reach, at.counts[d] - 1);
        all = all && from[d] == 0 && to[d] == at.counts[d] - 1;
        if (from[d] > 0) edge = least_of(edge, above(d, from[d]));
        if (to[d] < at.counts[d] - 1) edge = least_of(edge, -above(d, to[d] + 1));
      }
      for (std::int64_t k = from[2]; k <= to[2]; ++k)
        for (std::int64_t j = from[1]; j <= to[1]; ++j) {
          const bool known =
              was_from[1] <= j && j <= was_to[1] && was_from[2] <= k && k <= was_to[2];
          const double gap2 = gap2_of_row(j, k);
          const std::int64_t row = detail::row_of_cells(at.counts, j, k);
          if (!known) {
            row_of_best(row, gap2, from[0], to[0], best, see);
          } else {
            row_of_best(row, gap2, from[0], was_from[0] - 1, best, see);
            row_of_best(row, gap2, was_to[0] + 1, to[0], best, see);
          }
        }
      if (all) return;
      edge -= margin_;
      if (best.full() && edge > 0 &&
          edge * edge * (1 - rounding) > static_cast<double>(best.worst()))
        return;
      for (int d = 0; d < max_dimension; ++d) {
        was_from[d] = from[d];
        was_to[d] = to[d];
      }
    }
  }

  // Calls see(place, d2) for all within rho, by ascending place. `far` is reach(rho).
  template <class See>
  RECON_DEVICE void within(T rho, T far, const See& see) const {
    double half[D];
    for (int d = 0; d < D; ++d) half[d] = static_cast<double>(far);
    in_box(half, half[0] * half[0], [&](std::uint32_t place, T d2) {
      if (d2 <= rho * rho) see(place, d2);
    });
  }
  // Calls see(place, d2) for all in the box with these half edges, and some others near it, by
  // ascending place; rows of cells farther than sqrt(most2) are left out.
  template <class See>
  RECON_DEVICE void in_box(const double* half, double most2, const See& see) const {
    const Layout<T>& at = *cloud_.layout;
    std::int64_t from[max_dimension] = {0, 0, 0}, to[max_dimension] = {0, 0, 0};
    for (int d = 0; d < D; ++d) {
      const double wide = half[d] * (1 + 4 * eps) + margin_, x = static_cast<double>(x_[d]);
      from[d] = cell_at(d, x - wide);
      to[d] = cell_at(d, x + wide);
    }
    constexpr std::int64_t high = detail::rows_of_a_band;
    for (std::int64_t band = from[1] - from[1] % high; band <= to[1]; band += high)
      for (std::int64_t k = from[2]; k <= to[2]; ++k)
        for (std::int64_t j = most_of(band, from[1]); j <= least_of(band + high - 1, to[1]); ++j) {
          if (gap2_of_row(j, k) * (1 - rounding) > most2 * (1 + rounding)) continue;
          const std::int64_t row = detail::row_of_cells(at.counts, j, k);
          stretch(row + from[0], row + to[0], see);
        }
  }

 private:
  RECON_DEVICE std::int64_t cell_at(int d, double x) const {
    const Layout<T>& at = *cloud_.layout;
    return detail::cell_on_axis(x, at.lower[d], at.inverse, at.counts[d]);
  }
  // How far x lies above the lower face of a cell.
  RECON_DEVICE double above(int d, std::int64_t cell) const {
    const Layout<T>& at = *cloud_.layout;
    return static_cast<double>(x_[d]) - (at.lower[d] + static_cast<double>(cell) * at.size);
  }
  // The squared distance to a row of cells, in all but the first axis, or somewhat less.
  RECON_DEVICE double gap2_of_row(std::int64_t j, std::int64_t k) const {
    const std::int64_t cell[max_dimension] = {0, j, k};
    double gap2 = 0;
    for (int d = 1; d < D; ++d) {
      const double over = above(d, cell[d]), size = cloud_.layout->size;
      const double gap = (over < 0 ? -over : over - size) - margin_;
      if (gap > 0) gap2 += gap * gap;
    }
    return gap2;
  }
  // The cells a .. b of a row, or those of them that matter.
  template <class Best, class See>
  RECON_DEVICE void row_of_best(std::int64_t row, double gap2, std::int64_t a, std::int64_t b,
                                const Best& best, const See& see) const {
    if (a > b) return;
    if (best.full()) {
      const double left2 =
          static_cast<double>(best.worst()) * (1 + rounding) - gap2 * (1 - rounding);
      if (left2 < 0) return;
      const double half = std::sqrt(left2) + margin_, x = static_cast<double>(x_[0]);
      a = most_of(a, cell_at(0, x - half));
      b = least_of(b, cell_at(0, x + half));
      if (a > b) return;
    }
    stretch(row + a, row + b, see);
  }
  // The particles of the cells a .. b.
  template <class See>
  RECON_DEVICE void stretch(std::int64_t a, std::int64_t b, const See& see) const {
    const std::uint32_t end = cloud_.first[b + 1];
    for (std::uint32_t place = cloud_.first[a]; place < end; ++place)
      see(place, squared_distance_of<D>(x_, cloud_.x + std::size_t{place} * D));
  }

  const CloudView<D, T>& cloud_;
  const T* x_;
  double margin_ = 0;
};

// Where x lies seen from the particles that are shifted.
template <int D, class T>
RECON_DEVICE void move_by_shift(const Frame<D, T>& frame, const int* shift, const T* x, T* moved) {
  for (int d = 0; d < D; ++d)
    moved[d] =
        shift[d] == 0 ? x[d] : x[d] - plain_product(static_cast<T>(shift[d]), frame.period[d]);
}

template <bool periodic>
struct Named {
  ImageShift shift{};
  RECON_DEVICE KeyOf<periodic> operator()(std::uint32_t place) const {
    return detail::NeighbourKey<periodic>::of(place, shift);
  }
};

inline constexpr int most_shift = 127;

// The nearest to x, over all periodic images. False where a shift beyond 127 would be needed, or
// fewer than asked for are there.
template <bool periodic, int D, class T, class Best>
RECON_DEVICE bool find_nearest(const CloudView<D, T>& cloud, const T* x, int reach, Best& best) {
  if (cloud.count == 0) return best.most == 0;
  for (int d = 0; d < D; ++d)
    if (!(x[d] - x[d] == T(0))) return false;
  Around<D, T>(cloud, x).nearest(reach, Named<periodic>{}, best);
  if constexpr (periodic) {
    constexpr double rounding = 32 * static_cast<double>(std::numeric_limits<T>::epsilon());
    const double period = static_cast<double>(cloud.frame.least_period());
    // An image that is shifted by m periods along an axis is at least m - 1 periods away.
    for (int m = 1;; ++m) {
      const double least = (m - 1) * period;
      if (best.full() && least * least * (1 - rounding) > static_cast<double>(best.worst())) break;
      if (m > most_shift) return false;
      const int before = best.size;
      int to[max_dimension] = {0, 0, 0}, shift[max_dimension] = {0, 0, 0};
      for (int d = 0; d < D; ++d) to[d] = cloud.frame.periodic[d] ? m : 0;
      const auto size = [](int s) { return s < 0 ? -s : s; };
      for (shift[2] = -to[2]; shift[2] <= to[2]; ++shift[2])
        for (shift[1] = -to[1]; shift[1] <= to[1]; ++shift[1])
          for (shift[0] = -to[0]; shift[0] <= to[0]; ++shift[0]) {
            if (size(shift[0]) < m && size(shift[1]) < m && size(shift[2]) < m) continue;
            T seen[D];
            move_by_shift(cloud.frame, shift, x, seen);
            double outside2 = 0;
            for (int d = 0; d < D; ++d) {
              const T out = most_of(most_of(T(0), cloud.layout->box_lower[d] - seen[d]),
                                    seen[d] - cloud.layout->box_upper[d]);
              outside2 += static_cast<double>(out) * static_cast<double>(out);
            }
            if (best.full() && outside2 * (1 - rounding) > static_cast<double>(best.worst()))
              continue;
            Named<periodic> name;
            for (int d = 0; d < D; ++d) name.shift[d] = static_cast<std::int8_t>(shift[d]);
            Around<D, T>(cloud, seen).nearest(reach, name, best);
          }
      if (best.size == before && !best.full()) return false;  // no particle has a place
    }
  }
  return best.full();
}

// Calls see(key) for all within rho of x, over all periodic images; without them by ascending key.
// False where a shift beyond 127 would be needed.
template <bool periodic, int D, class T, class See>
RECON_DEVICE bool find_within(const CloudView<D, T>& cloud, const T* x, T rho, T far,
                              const See& see) {
  if (cloud.count == 0) return true;
  int from[max_dimension] = {0, 0, 0}, to[max_dimension] = {0, 0, 0};
  if constexpr (periodic) {
    // May particles that are shifted so along an axis be within the radius?
    const auto meets = [&](int d, int shift) {
      const T move = plain_product(static_cast<T>(shift), cloud.frame.period[d]);
      return x[d] - move - far <= cloud.layout->box_upper[d] &&
             x[d] - move + far >= cloud.layout->box_lower[d];
    };
    for (int d = 0; d < D; ++d) {
      if (!cloud.frame.periodic[d]) continue;
      while (from[d] >= -most_shift && meets(d, from[d] - 1)) --from[d];
      while (to[d] <= most_shift && meets(d, to[d] + 1)) ++to[d];
      if (from[d] < -most_shift || to[d] > most_shift) return false;
    }
  }
  int shift[max_dimension];
  for (shift[0] = from[0]; shift[0] <= to[0]; ++shift[0])
    for (shift[1] = from[1]; shift[1] <= to[1]; ++shift[1])
      for (shift[2] = from[2]; shift[2] <= to[2]; ++shift[2]) {
        T seen[D];
        move_by_shift(cloud.frame, shift, x, seen);
        Named<periodic> name;
        for (int d = 0; d < D; ++d) name.shift[d] = static_cast<std::int8_t>(shift[d]);
        Around<D, T>(cloud, seen).within(rho, far, [&](std::uint32_t place, T) {
          see(name(place));
        });
      }
  return true;
}

}  // namespace recon::cuda
