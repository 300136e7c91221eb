#include "neighbourhood/cell_kernel.hpp"

#include <cmath>
#include <limits>

#include "core/instantiate.hpp"
#include "recon/core/pack.hpp"

#ifdef __AVX512VL__
#include <immintrin.h>
#endif

namespace recon::detail::RECON_SET {

namespace {

// Appends the lanes of one vector of candidates that are `near`, of which there are `left`.
#ifdef __AVX512VL__
inline void append(Gathered<double>& out, __m512d distance2, __mmask8 near,
                   const std::uint32_t* index) {
  _mm512_storeu_pd(out.distance2 + out.count, _mm512_maskz_compress_pd(near, distance2));
  const __m256i all = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(index));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(out.index + out.count),
                      _mm256_maskz_compress_epi32(near, all));
  out.count += __builtin_popcount(near);
}
inline void append(Gathered<float>& out, __m512 distance2, __mmask16 near,
                   const std::uint32_t* index) {
  _mm512_storeu_ps(out.distance2 + out.count, _mm512_maskz_compress_ps(near, distance2));
  _mm512_storeu_si512(out.index + out.count,
                      _mm512_maskz_compress_epi32(near, _mm512_loadu_si512(index)));
  out.count += __builtin_popcount(near);
}

inline __mmask8 at_most(__m512d a, double b) {
  return _mm512_cmp_pd_mask(a, _mm512_set1_pd(b), _CMP_LE_OQ);
}
inline __mmask16 at_most(__m512 a, float b) {
  return _mm512_cmp_ps_mask(a, _mm512_set1_ps(b), _CMP_LE_OQ);
}
inline __m512d native(Pack<double> a) {
  return static_cast<__m512d>(a);
}
inline __m512 native(Pack<float> a) {
  return static_cast<__m512>(a);
}

// `measure` is compared with the limit.
template <class S>
inline void take(Gathered<S>& out, const Pack<S>& distance2, const Pack<S>& measure, S limit,
                 std::int64_t left, const std::uint32_t* index) {
  constexpr int lanes = LaneTraits<Pack<S>>::lanes;
  const unsigned there = left >= lanes ? ~0u : (1u << left) - 1;
  const auto near = at_most(native(measure), limit);
  append(out, native(distance2), static_cast<decltype(near)>(near & there), index);
}
#else
template <class S>
inline void take(Gathered<S>& out, const Pack<S>& distance2, const Pack<S>& measure, S limit,
                 std::int64_t left, const std::uint32_t* index) {
  constexpr int lanes = LaneTraits<Pack<S>>::lanes;
  const int there = left < lanes ? static_cast<int>(left) : lanes;
  S measures[lanes], distances[lanes];
  measure.copy_to(measures, std::experimental::element_aligned);
  distance2.copy_to(distances, std::experimental::element_aligned);
  for (int l = 0; l < lanes; ++l) {  // always written, counted if near
    out.distance2[out.count] = distances[l];
    out.index[out.count] = index[l];
    out.count += static_cast<int>(measures[l] <= limit) & static_cast<int>(l < there);
  }
}
#endif

// Of the particles first..first + left - 1, as many as fit a vector, those that are near enough.
template <class S, int D, bool cube>
inline void gather_vector(const CellView<S>& cells, const S* x, S limit, std::int64_t first,
                          std::int64_t left, Gathered<S>& out) {
  using P = Pack<S>;
  P sum(S(0)), farthest(S(0));
  for (int d = 0; d < D; ++d) {
    const P gap = P(x[d]) - P(cells.x[d] + first, std::experimental::element_aligned);
    if (cube) {
      const P size = select(gap > P(S(0)), gap, -gap);
      farthest = select(size > farthest, size, farthest);
    }
    sum = d == 0 ? gap * gap : sum + gap * gap;
  }
  take(out, sum, cube ? farthest : sum, limit, left, cells.index + first);
}

// Vectors of particles still to be looked at. They are listed first and looked at together, because
// how many there are in a row cannot be predicted: the processor would guess wrong in every row.
struct Vectors {
  static constexpr int most = 96;
  int count = 0;
  std::int64_t first[most], left[most];

  // If the condition holds; without a branch.
  void add_if(bool condition, std::int64_t at, std::int64_t particles) {
    first[count] = at;
    left[count] = particles;
    count += condition;
  }
};

template <class S, int D, bool cube>
inline void gather_listed(const CellView<S>& cells, const S* x, S limit, Vectors& listed,
                          Gathered<S>& out) {
  for (int v = 0; v < listed.count; ++v)
    gather_vector<S, D, cube>(cells, x, limit, listed.first[v], listed.left[v], out);
  listed.count = 0;
}

// How far x is at least from particles in cell `at` of axis d.
template <class S>
inline double gap_to_cell(const CellView<S>& cells, int d, double x, std::int64_t at,
                          double slack) {
  const double low = cells.lower[d] + static_cast<double>(at) * cells.size;
  const double below = low - x, above = x - (low + cells.size);
  const double gap = (below > above ? below : above) - slack;
  return gap > 0 ? gap : 0;
}

template <class S, int D, bool cube>
inline GatherResult gather(const CellView<S>& cells, const S* x, S radius, Gathered<S>& out) {
  constexpr double eps = std::numeric_limits<double>::epsilon();
  constexpr auto eps_s = static_cast<double>(std::numeric_limits<S>::epsilon());
  constexpr auto least = static_cast<double>(std::numeric_limits<S>::min());
  // Nothing near enough is farther than this, in spite of rounding and of squares that underflow.
  const S limit = cube ? radius : radius * radius;
  const auto wide = static_cast<double>(limit);
  const double reach2 = (cube ? D * wide * wide : wide) * (1 + 32 * eps_s) + (cube ? 0 : 8 * least);
  const double reach =
      cube ? wide * (1 + 32 * eps_s) + std::numeric_limits<double>::min() : std::sqrt(reach2);

  double at[3] = {0, 0, 0}, slack[3] = {0, 0, 0};  // slack: what the borders of cells are off
  std::int64_t from[3] = {0, 0, 0}, to[3] = {0, 0, 0};
  for (int d = 0; d < D; ++d) {
    at[d] = static_cast<double>(x[d]);
    slack[d] =
        16 * eps * (std::fabs(cells.lower[d]) + std::fabs(cells.upper[d]) + std::fabs(at[d]));
    if (d == 0) continue;
    const double half = reach * (1 + 4 * eps) + slack[d];
    from[d] = cell_on_axis(at[d] - half, cells.lower[d], cells.inverse, cells.counts[d]);
    to[d] = cell_on_axis(at[d] + half, cells.lower[d], cells.inverse, cells.counts[d]);
  }
  constexpr std::int64_t lanes = LaneTraits<Pack<S>>::lanes;
  const std::int64_t start = out.count;
  Vectors listed;
  std::int64_t particles = 0;  // in the stretches so far: at most so many are found
  for (std::int64_t k = from[2]; k <= to[2]; ++k) {
    const double gap_z = D > 2 ? gap_to_cell(cells, 2, at[2], k, slack[2]) : 0;
    const double left_z = reach2 - gap_z * gap_z;
    for (std::int64_t j = from[1]; j <= to[1]; ++j) {
      const double gap_y = D > 1 ? gap_to_cell(cells, 1, at[1], j, slack[1]) : 0;
      const double left = left_z - gap_y * gap_y;
      const double chord = cube ? reach : std::sqrt(left > 0 ? left : 0);
      const double half = chord * (1 + 4 * eps) + slack[0];
      const std::int64_t row = row_of_cells(cells.counts, j, k);
      const std::int64_t a =
          cell_on_axis(at[0] - half, cells.lower[0], cells.inverse, cells.counts[0]);
      const std::int64_t b =
          cell_on_axis(at[0] + half, cells.lower[0], cells.inverse, cells.counts[0]);
      const std::int64_t first = cells.first[row + a];
      const std::int64_t all = cells.first[row + b + 1] - first;
      const std::int64_t length = cube || left >= 0 ? all : 0;
      particles += length;
      out.work += work_of_a_row + length;
      if (out.work + out.work_per_found * out.count > out.work_limit)
        return GatherResult::too_much_work;
      if (start + particles + 16 > out.capacity) return GatherResult::no_room;
      listed.add_if(length > 0, first, length);
      listed.add_if(length > lanes, first + lanes, length - lanes);
      for (std::int64_t done = 2 * lanes; done < length; done += lanes)
        gather_vector<S, D, cube>(cells, x, limit, first + done, length - done, out);
      if (listed.count > Vectors::most - 3) gather_listed<S, D, cube>(cells, x, limit, listed, out);
    }
  }
  gather_listed<S, D, cube>(cells, x, limit, listed, out);
  return GatherResult::complete;
}

// Of `vectors` vectors of values from `begin` on.
template <class T, int vectors>
inline void rank_some(const T* values, std::int64_t count, std::int64_t begin, T* rank) {
  using P = Pack<T>;
  constexpr int lanes = LaneTraits<P>::lanes;
  P own[vectors], smaller_ones[vectors];
  for (int v = 0; v < vectors; ++v) {
    own[v].copy_from(values + begin + v * lanes, std::experimental::element_aligned);
    smaller_ones[v] = P(T(0));
  }
  for (std::int64_t j = 0; j < count; ++j) {
    const P other(values[j]);
    for (int v = 0; v < vectors; ++v) smaller_ones[v] += select(other < own[v], P(T(1)), P(T(0)));
  }
  for (int v = 0; v < vectors; ++v)
    smaller_ones[v].copy_to(rank + begin + v * lanes, std::experimental::element_aligned);
}

}  // namespace

template <class S, int D>
GatherResult gather_ball(const CellView<S>& cells, const S* x, S radius, Gathered<S>& out) {
  return gather<S, D, false>(cells, x, radius, out);
}

template <class S, int D>
GatherResult gather_cube(const CellView<S>& cells, const S* x, S radius, Gathered<S>& out) {
  return gather<S, D, true>(cells, x, radius, out);
}

template <class T>
void ranks(T* values, std::int64_t count, T* rank) {
  constexpr int lanes = LaneTraits<Pack<T>>::lanes;
  for (int l = 0; l < 4 * lanes; ++l) values[count + l] = T(0);  // ranked, and not looked at
  std::int64_t begin = 0;
  for (; count - begin > 2 * lanes; begin += 4 * lanes) rank_some<T, 4>(values, count, begin, rank);
  if (count - begin > lanes)
    rank_some<T, 2>(values, count, begin, rank);
  else if (count > begin)
    rank_some<T, 1>(values, count, begin, rank);
}

#define RECON_INSTANTIATE(S, D)                                                           \
  template GatherResult gather_ball<S, D>(const CellView<S>&, const S*, S, Gathered<S>&); \
  template GatherResult gather_cube<S, D>(const CellView<S>&, const S*, S, Gathered<S>&)
RECON_FOR_EACH_SCALAR_AND_DIMENSION(RECON_INSTANTIATE);
#undef RECON_INSTANTIATE
template void ranks<float>(float*, std::int64_t, float*);
template void ranks<double>(double*, std::int64_t, double*);
template void ranks<std::uint32_t>(std::uint32_t*, std::int64_t, std::uint32_t*);

}  // namespace recon::detail::RECON_SET
