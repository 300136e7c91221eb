// Rows of nodes, four numbers at a time.
#include "transfer/row_kernel.hpp"

namespace recon::detail::RECON_SET {
namespace {

#if defined(__AVX__)
constexpr int part_width = 4;
#else
constexpr int part_width = 2;
#endif
typedef double Part __attribute__((vector_size(8 * part_width)));
typedef std::int32_t Whole __attribute__((vector_size(4 * part_width)));
typedef std::uint32_t Numbers __attribute__((vector_size(4 * part_width)));

// Four numbers in as many registers as they need.
struct Four {
  static constexpr int parts = 4 / part_width;
  Part part[parts];

  static inline Four load(const double* from) {
    Four out;
    __builtin_memcpy(out.part, from, sizeof(out.part));
    return out;
  }
  inline void store(double* to) const { __builtin_memcpy(to, part, sizeof(part)); }
  inline Four times(double factor) const {
    Four out;
    for (int i = 0; i < parts; ++i) out.part[i] = factor * part[i];
    return out;
  }
  // += factor * other
  inline void add(double factor, const Four& other) {
    for (int i = 0; i < parts; ++i) part[i] += factor * other.part[i];
  }
};
constexpr double zeros[4] = {0, 0, 0, 0};

inline void add_to(double* four, double factor, const Four& what) {
  Four sum = Four::load(four);
  sum.add(factor, what);
  sum.store(four);
}

template <int>
struct Number {};

template <int D, bool with_modes, bool with_squares>
inline void give_to_rows(const NodeList& at, const Given& given, double* rows) {
  const Four value = Four::load(given.value);
  Four slope[D];
  for (int d = 0; d < D; ++d) slope[d] = Four::load(given.slope[d]);
  const double last[4] = {0, 0, 0, given.squared};
  const Four squared = Four::load(last);
  const double* G = at.G;
  for (std::size_t k = 0; k < at.count; ++k, G += D) {
    double* row = rows + 8 * static_cast<std::size_t>(at.node[k]);
    Four low = Four::load(row), high = Four::load(row + 4), shown = value;
    if constexpr (with_modes) {
      const double* polynomial =
          given.modes.value + static_cast<std::ptrdiff_t>(k) * given.modes.of_node;
      for (std::size_t r = 0; r < given.modes.count; ++r, polynomial += given.modes.of_mode)
        shown.add(*polynomial, Four::load(given.coefficients + 4 * r));
    }
    low.add(at.S[k], shown);
    for (int d = 0; d < D; ++d) {
      if constexpr (with_squares) {
        Four both = slope[d];
        both.add(G[d], squared);
        high.add(G[d], both);
      } else {
        high.add(G[d], slope[d]);
      }
    }
    low.store(row);
    high.store(row + 4);
  }
}

// The modes r, ..., r + n - 1.
template <int n>
inline void take_some_modes(const NodeList& at, const ModeList& modes, std::size_t r,
                            const double* rows, double* out) {
  Four sum[n];
  for (int i = 0; i < n; ++i) sum[i] = Four::load(zeros);
  const double* polynomial = modes.value + static_cast<std::ptrdiff_t>(r) * modes.of_mode;
  for (std::size_t k = 0; k < at.count; ++k, polynomial += modes.of_node) {
    Four part = Four::load(zeros);
    part.add(at.S[k], Four::load(rows + 8 * static_cast<std::size_t>(at.node[k])));
    for (int i = 0; i < n; ++i) sum[i].add(polynomial[i * modes.of_mode], part);
  }
  for (int i = 0; i < n; ++i) sum[i].store(out + 4 * (r + static_cast<std::size_t>(i)));
}

// The products over all axes but the first: with values alone, with the derivative along an axis,
// and with its mode.
struct Others {
  double S, G[3], M[3];
};

// Calls line(row number of the first node, products) for all lines of nodes along the first axis.
// `n` is the number of nodes on every axis, or 0 where these numbers differ.
template <int D, int n, bool with_slopes, bool with_modes, class Line>
inline void for_lines(const ProductList& at, const Line& line) {
  if constexpr (D == 1) {
    line(at.first, Others{1, {}, {}});
  } else {
    const int along = n > 0 ? n : at.count[1], across = D == 2 ? 1 : n > 0 ? n : at.count[2];
    for (int k = 0; k < across; ++k) {
      const std::size_t begin =
          D == 2 ? at.first : at.first + static_cast<std::size_t>(k) * at.stride[2];
      for (int j = 0; j < along; ++j) {
        Others others;
        const double y = at.S[1][j], z = D == 2 ? 1 : at.S[2][k];
        others.S = D == 2 ? y : y * z;
        if constexpr (with_slopes) {
          others.G[1] = D == 2 ? at.G[1][j] : at.G[1][j] * z;
          if constexpr (D == 3) others.G[2] = y * at.G[2][k];
        }
        if constexpr (with_modes) {
          others.M[1] = D == 2 ? at.M[1][j] : at.M[1][j] * z;
          if constexpr (D == 3) others.M[2] = y * at.M[2][k];
        }
        line(begin + static_cast<std::size_t>(j) * at.stride[1], others);
      }
    }
  }
}

template <int D, int n, bool with_modes, bool with_squares>
inline void give_to_product(const ProductList& at, const Given& given, double* rows) {
  const Four value = Four::load(given.value);
  Four slope[D], mode[D];
  for (int d = 0; d < D; ++d) {
    slope[d] = Four::load(given.slope[d]);
    if constexpr (with_modes) mode[d] = Four::load(given.coefficients + 4 * d);
  }
  const double last[4] = {0, 0, 0, given.squared};
  const Four squared = Four::load(last);
  const double *S = at.S[0], *G = at.G[0], *M = at.M[0];
  const int count = n > 0 ? n : at.count[0];
  for_lines<D, n, true, with_modes>(at, [&](std::size_t first, const Others& others) {
    // What goes to a node with S, with G and with M of the first axis.
    Four low = value.times(others.S), high = Four::load(zeros);
    for (int d = 1; d < D; ++d) {
      high.add(others.G[d], slope[d]);
      if constexpr (with_modes) low.add(others.M[d], mode[d]);
    }
    const Four high_by_G = slope[0].times(others.S);
    const Four low_by_M = with_modes ? mode[0].times(others.S) : low;
    double across = 0;
    for (int d = 1; d < D && with_squares; ++d) across += others.G[d] * others.G[d];
    double* row = rows + 8 * first;
    for (int i = 0; i < count; ++i, row += 8) {
      Four sum = Four::load(row), other = Four::load(row + 4);
      sum.add(S[i], low);
      if constexpr (with_modes) sum.add(M[i], low_by_M);
      other.add(S[i], high);
      other.add(G[i], high_by_G);
      if constexpr (with_squares)
        other.add(G[i] * G[i] * (others.S * others.S) + S[i] * S[i] * across, squared);
      sum.store(row);
      other.store(row + 4);
    }
  });
}

template <int D, int n, bool with_modes, bool same>
inline void take_from_product(const ProductList& at, const double* rows, const double* sloping,
                              std::ptrdiff_t stride, Taken& taken) {
  const Four zero = Four::load(zeros);
  Four low = zero, high = zero, slope[D], moment[D];
  for (int d = 0; d < D; ++d) slope[d] = moment[d] = zero;
  const double *S = at.S[0], *G = at.G[0], *M = at.M[0];
  const int count = n > 0 ? n : at.count[0];
  for_lines<D, n, true, with_modes>(at, [&](std::size_t first, const Others& others) {
    Four low_by_S = zero, high_by_S = zero, by_G = zero, by_M = zero, strained_by_S = zero;
    const double* row = rows + 8 * first;
    const double* strained = sloping + stride * static_cast<std::ptrdiff_t>(first);
    for (int i = 0; i < count; ++i, row += 8, strained += stride) {
      const Four here = Four::load(row);
      low_by_S.add(S[i], here);
      high_by_S.add(S[i], Four::load(row + 4));
      if constexpr (with_modes) by_M.add(M[i], here);
      if constexpr (same) {
        by_G.add(G[i], here);
      } else {
        const Four there = Four::load(strained);
        by_G.add(G[i], there);
        strained_by_S.add(S[i], there);
      }
    }
    low.add(others.S, low_by_S);
    high.add(others.S, high_by_S);
    slope[0].add(others.S, by_G);
    if constexpr (with_modes) moment[0].add(others.S, by_M);
    for (int d = 1; d < D; ++d) {
      slope[d].add(others.G[d], same ? low_by_S : strained_by_S);
      if constexpr (with_modes) moment[d].add(others.M[d], low_by_S);
    }
  });
  low.store(taken.value);
  high.store(taken.value + 4);
  for (int d = 0; d < D; ++d) {
    slope[d].store(taken.slope[d]);
    if constexpr (with_modes) moment[d].store(taken.moment[d]);
  }
}

// Calls work(integral constant n) with the number of nodes on every axis, or with 0.
template <int D, class Work>
inline void with_count(const ProductList& at, const Work& work) {
  bool two = true, three = true;
  for (int d = 0; d < D; ++d) {
    two = two && at.count[d] == 2;
    three = three && at.count[d] == 3;
  }
  if (two)
    work(Number<2>{});
  else if (three)
    work(Number<3>{});
  else
    work(Number<0>{});
}

// Calls pair(first node, N at it, N at the next) for the pairs of nodes around a corner.
template <int D, class Pair>
inline void for_pairs(const CornerList& at, int a, const Pair& pair) {
  const double upper = at.xi[0][a], lower = 1 - upper;
  const std::size_t first = at.first[a];
  if constexpr (D == 1) {
    pair(first, lower, upper);
  } else {
    const double y = at.xi[1][a];
    const auto line = [&](std::size_t begin, double z) {
      const double near = (1 - y) * z, far = y * z;
      pair(begin, lower * near, upper * near);
      pair(begin + at.stride[1], lower * far, upper * far);
    };
    if constexpr (D == 2) {
      line(first, 1);
    } else {
      line(first, 1 - at.xi[2][a]);
      line(first + at.stride[2], at.xi[2][a]);
    }
  }
}

// Where the corners lie, as CartesianGrid::cell() and node() say; false where one may not be finite.
// There are eight of them, of which some may not be used.
template <int D>
inline bool find(const CornerGrid& grid, const double (&x)[D][8], CornerList& at) {
  constexpr Part none = {};
  Part zero = none;  // and NaN where a place is not finite
  std::uint32_t stride[D];
  for (int d = 0; d < D; ++d)
    at.stride[d] = stride[d] =
        d == 0 ? 1 : stride[d - 1] * static_cast<std::uint32_t>(grid.cells[d - 1] + 1);
  for (int begin = 0; begin < 8; begin += part_width) {
    Numbers first = {};
    for (int d = 0; d < D; ++d) {
      const Part lower = none + grid.lower[d], last = none + (grid.cells[d] - 1.0);
      Part here;
      __builtin_memcpy(&here, &x[d][begin], sizeof here);
      const Part place = (here - lower) / grid.h;
      zero += place - place;
      const Part above = place > none ? place : none;
      const Whole cell = __builtin_convertvector(above < last ? above : last, Whole);
      first += __builtin_convertvector(cell, Numbers) * stride[d];
      const Part xi = (here - (lower + __builtin_convertvector(cell, Part) * grid.h)) * grid.per_h;
      __builtin_memcpy(&at.xi[d][begin], &xi, sizeof xi);
    }
    __builtin_memcpy(&at.first[begin], &first, sizeof first);
  }
  double sum = 0;
  for (int i = 0; i < part_width; ++i) sum += zero[i];
  return sum == 0;
}

template <int D, bool same>
inline void take_from_corners(const CornerList& at, const double* rows, const double* sloping,
                              std::ptrdiff_t stride, Taken& taken) {
  const Four zero = Four::load(zeros);
  Four low = zero, high = zero, slope[D];
  for (int d = 0; d < D; ++d) slope[d] = zero;
  for (int a = 0; a < 1 << D; ++a) {
    Four low_there = zero, high_there = zero, strained = zero;
    for_pairs<D>(at, a, [&](std::size_t first, double N, double next) {
      const double* row = rows + 8 * first;
      low_there.add(N, Four::load(row));
      high_there.add(N, Four::load(row + 4));
      low_there.add(next, Four::load(row + 8));
      high_there.add(next, Four::load(row + 12));
      if constexpr (!same) {
        const double* other = sloping + stride * static_cast<std::ptrdiff_t>(first);
        strained.add(N, Four::load(other));
        strained.add(next, Four::load(other + stride));
      }
    });
    low.add(at.weight[a], low_there);
    high.add(at.weight[a], high_there);
    for (int d = 0; d < D; ++d) slope[d].add(at.slope[d][a], same ? low_there : strained);
  }
  low.store(taken.value);
  high.store(taken.value + 4);
  for (int d = 0; d < D; ++d) slope[d].store(taken.slope[d]);
}

}  // namespace

template <int D>
void give_product(const ProductList& at, const Given& given, double* rows) {
  with_count<D>(at, [&]<int n>(Number<n>) {
    if (at.M[0]) {
      if (given.squared != 0)
        give_to_product<D, n, true, true>(at, given, rows);
      else
        give_to_product<D, n, true, false>(at, given, rows);
    } else if (given.squared != 0) {
      give_to_product<D, n, false, true>(at, given, rows);
    } else {
      give_to_product<D, n, false, false>(at, given, rows);
    }
  });
}

template <int D>
void take_product(const ProductList& at, const double* rows, const double* sloping,
                  std::ptrdiff_t stride, Taken& taken) {
  with_count<D>(at, [&]<int n>(Number<n>) {
    if (at.M[0]) {
      if (sloping == rows)
        take_from_product<D, n, true, true>(at, rows, sloping, stride, taken);
      else
        take_from_product<D, n, true, false>(at, rows, sloping, stride, taken);
    } else if (sloping == rows) {
      take_from_product<D, n, false, true>(at, rows, sloping, stride, taken);
    } else {
      take_from_product<D, n, false, false>(at, rows, sloping, stride, taken);
    }
  });
}

template <int D>
void give_four_product(const ProductList& at, const double* four, double* rows) {
  const Four given = Four::load(four);
  with_count<D>(at, [&]<int n>(Number<n>) {
    const int count = n > 0 ? n : at.count[0];
    for_lines<D, n, false, false>(at, [&](std::size_t first, const Others& others) {
      const Four part = given.times(others.S);
      double* row = rows + 4 * first;
      for (int i = 0; i < count; ++i, row += 4) {
        Four sum = Four::load(row);
        sum.add(at.S[0][i], part);
        sum.store(row);
      }
    });
  });
}

template <int D>
void take_four_product(const ProductList& at, const double* rows, double* four) {
  Four sum = Four::load(zeros);
  with_count<D>(at, [&]<int n>(Number<n>) {
    const int count = n > 0 ? n : at.count[0];
    for_lines<D, n, false, false>(at, [&](std::size_t first, const Others& others) {
      Four part = Four::load(zeros);
      const double* row = rows + 4 * first;
      for (int i = 0; i < count; ++i, row += 4) part.add(at.S[0][i], Four::load(row));
      sum.add(others.S, part);
    });
  });
  sum.store(four);
}

template <int D>
bool find_corners(const CornerGrid& grid, const double* corners, const double* weight,
                  const double* slope, CornerList& at) {
  constexpr int count = 1 << D;
  double x[D][8];
  for (int a = 0; a < 8; ++a) {
    const int of = a < count ? a : 0;
    for (int d = 0; d < D; ++d) {
      x[d][a] = corners[D * of + d];
      at.slope[d][a] = slope[D * of + d];
    }
    at.weight[a] = weight[of];
  }
  return find<D>(grid, x, at);
}

template <int D>
bool find_parallelepiped(const CornerGrid& grid, const double* x, const double* half_edges,
                         const double* inverse, CornerList& at) {
  static constexpr double signs[3][8] = {
      {-1, 1, -1, 1, -1, 1, -1, 1}, {-1, -1, 1, 1, -1, -1, 1, 1}, {-1, -1, -1, -1, 1, 1, 1, 1}};
  constexpr double weight = 1.0 / (1 << D);
  double corner[D][8];
  for (int begin = 0; begin < 8; begin += part_width) {
    Part sign[D];
    for (int d = 0; d < D; ++d) __builtin_memcpy(&sign[d], &signs[d][begin], sizeof(Part));
    for (int d = 0; d < D; ++d) {
      Part place = Part{} + x[d], slope = {};
      for (int e = 0; e < D; ++e) {
        place += sign[e] * half_edges[D * e + d];
        slope += sign[e] * (inverse[D * d + e] * weight);
      }
      __builtin_memcpy(&corner[d][begin], &place, sizeof place);
      __builtin_memcpy(&at.slope[d][begin], &slope, sizeof slope);
    }
  }
  for (int a = 0; a < 8; ++a) at.weight[a] = weight;
  return find<D>(grid, corner, at);
}

template <int D>
void give_corners(const CornerList& at, const Given& given, double* rows) {
  const Four value = Four::load(given.value);
  Four slope[D];
  for (int d = 0; d < D; ++d) slope[d] = Four::load(given.slope[d]);
  for (int a = 0; a < 1 << D; ++a) {
    const Four low = value.times(at.weight[a]);
    Four high = slope[0].times(at.slope[0][a]);
    for (int d = 1; d < D; ++d) high.add(at.slope[d][a], slope[d]);
    for_pairs<D>(at, a, [&](std::size_t first, double N, double next) {
      double* row = rows + 8 * first;
      add_to(row, N, low);
      add_to(row + 4, N, high);
      add_to(row + 8, next, low);
      add_to(row + 12, next, high);
    });
  }
}

template <int D>
void take_corners(const CornerList& at, const double* rows, const double* sloping,
                  std::ptrdiff_t stride, Taken& taken) {
  if (sloping == rows)
    take_from_corners<D, true>(at, rows, sloping, stride, taken);
  else
    take_from_corners<D, false>(at, rows, sloping, stride, taken);
}

template <int D>
void give_four_corners(const CornerList& at, const double* four, double* rows) {
  const Four given = Four::load(four);
  for (int a = 0; a < 1 << D; ++a) {
    const Four part = given.times(at.weight[a]);
    for_pairs<D>(at, a, [&](std::size_t first, double N, double next) {
      double* row = rows + 4 * first;
      add_to(row, N, part);
      add_to(row + 4, next, part);
    });
  }
}

template <int D>
void take_four_corners(const CornerList& at, const double* rows, double* four) {
  Four sum = Four::load(zeros);
  for (int a = 0; a < 1 << D; ++a) {
    Four there = Four::load(zeros);
    for_pairs<D>(at, a, [&](std::size_t first, double N, double next) {
      there.add(N, Four::load(rows + 4 * first));
      there.add(next, Four::load(rows + 4 * first + 4));
    });
    sum.add(at.weight[a], there);
  }
  sum.store(four);
}

template <int D>
void give(const NodeList& at, const Given& given, double* rows) {
  if (given.modes.count > 0) {
    if (given.squared != 0)
      give_to_rows<D, true, true>(at, given, rows);
    else
      give_to_rows<D, true, false>(at, given, rows);
  } else if (given.squared != 0) {
    give_to_rows<D, false, true>(at, given, rows);
  } else {
    give_to_rows<D, false, false>(at, given, rows);
  }
}

template <int D>
void take(const NodeList& at, const double* rows, const double* sloping, std::ptrdiff_t stride,
          Taken& taken) {
  Four low = Four::load(zeros), high = low, slope[D];
  for (int d = 0; d < D; ++d) slope[d] = low;
  const double* G = at.G;
  for (std::size_t k = 0; k < at.count; ++k, G += D) {
    const double* row = rows + 8 * static_cast<std::size_t>(at.node[k]);
    low.add(at.S[k], Four::load(row));
    high.add(at.S[k], Four::load(row + 4));
    const Four strained = Four::load(sloping + stride * static_cast<std::ptrdiff_t>(at.node[k]));
    for (int d = 0; d < D; ++d) slope[d].add(G[d], strained);
  }
  low.store(taken.value);
  high.store(taken.value + 4);
  for (int d = 0; d < D; ++d) slope[d].store(taken.slope[d]);
}

void take_modes(const NodeList& at, const ModeList& modes, const double* rows, double* out) {
  std::size_t r = 0;
  for (; r + 8 <= modes.count; r += 8) take_some_modes<8>(at, modes, r, rows, out);
  for (; r + 3 <= modes.count; r += 3) take_some_modes<3>(at, modes, r, rows, out);
  for (; r < modes.count; ++r) take_some_modes<1>(at, modes, r, rows, out);
}

void give_four(const NodeList& at, const double* four, double* rows) {
  const Four given = Four::load(four);
  for (std::size_t k = 0; k < at.count; ++k) {
    double* row = rows + 4 * static_cast<std::size_t>(at.node[k]);
    Four sum = Four::load(row);
    sum.add(at.S[k], given);
    sum.store(row);
  }
}

void take_four(const NodeList& at, const double* rows, double* four) {
  Four sum = Four::load(zeros);
  for (std::size_t k = 0; k < at.count; ++k)
    sum.add(at.S[k], Four::load(rows + 4 * static_cast<std::size_t>(at.node[k])));
  sum.store(four);
}

#define RECON_INSTANTIATE(D)                                                                      \
  template void give<D>(const NodeList&, const Given&, double*);                                  \
  template void take<D>(const NodeList&, const double*, const double*, std::ptrdiff_t, Taken&);   \
  template void give_product<D>(const ProductList&, const Given&, double*);                       \
  template void take_product<D>(const ProductList&, const double*, const double*, std::ptrdiff_t, \
                                Taken&);                                                          \
  template void give_four_product<D>(const ProductList&, const double*, double*);                 \
  template void take_four_product<D>(const ProductList&, const double*, double*);                 \
  template bool find_corners<D>(const CornerGrid&, const double*, const double*, const double*,   \
                                CornerList&);                                                     \
  template bool find_parallelepiped<D>(const CornerGrid&, const double*, const double*,           \
                                       const double*, CornerList&);                               \
  template void give_corners<D>(const CornerList&, const Given&, double*);                        \
  template void take_corners<D>(const CornerList&, const double*, const double*, std::ptrdiff_t,  \
                                Taken&);                                                          \
  template void give_four_corners<D>(const CornerList&, const double*, double*);                  \
  template void take_four_corners<D>(const CornerList&, const double*, double*)
RECON_INSTANTIATE(1);
RECON_INSTANTIATE(2);
RECON_INSTANTIATE(3);
#undef RECON_INSTANTIATE

}  // namespace recon::detail::RECON_SET
