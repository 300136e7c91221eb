#include "neighbourhood/cell_kernel.hpp"

#include <limits>

#include "core/instantiate.hpp"
#include "recon/core/pack.hpp"

#ifdef __AVX512VL__
#include <immintrin.h>
#endif

namespace recon::detail::RECON_SET {

namespace {

namespace stdx = std::experimental;
using Floats = Pack<float>;
constexpr std::int64_t lanes = LaneTraits<Floats>::lanes;

// From where on a measure is nearly the largest (FarArrays).
inline float far_from(float largest, float slack) {
  return (largest - slack) * (1 - 1.0f / (1 << 19));
}

// Of the particles first .. first + left - 1, as many as `lanes`, those in the box.
#ifdef __AVX512VL__
inline __m512 about(const std::int32_t* x, std::int32_t centre) {
  return _mm512_cvtepi32_ps(_mm512_sub_epi32(_mm512_loadu_si512(x), _mm512_set1_epi32(centre)));
}
inline __m512 about(const float* x, float) {
  return _mm512_loadu_ps(x);
}

inline __mmask16 first_lanes(std::int64_t count) {
  const std::int64_t there = count < 0 ? 0 : count < lanes ? count : lanes;
  return static_cast<__mmask16>((1u << there) - 1);
}

inline __m512i numbers_from(std::int64_t first) {
  return _mm512_add_epi32(_mm512_set1_epi32(static_cast<int>(first)),
                          _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15));
}

template <int D>
struct InBox {
  __m512 x[D];
  __mmask16 inside;
};

template <class S, int D>
inline InBox<D> look_at(const CellView<S>& cells, const CellBox<S>& box, std::int64_t first,
                        std::int64_t left) {
  InBox<D> seen;
  seen.inside = first_lanes(left);
  for (int d = 0; d < D; ++d) {
    seen.x[d] = about(cells.x[d] + first, box.centre[d]);
    seen.inside =
        _mm512_mask_cmp_ps_mask(seen.inside, seen.x[d], _mm512_set1_ps(box.lower[d]), _CMP_GE_OQ);
    seen.inside =
        _mm512_mask_cmp_ps_mask(seen.inside, seen.x[d], _mm512_set1_ps(box.upper[d]), _CMP_LE_OQ);
  }
  return seen;
}

template <int D>
inline void add(const InBox<D>& seen, std::int64_t first, CandidateArrays& out) {
  for (int d = 0; d < D; ++d)
    _mm512_storeu_ps(out.x[d] + out.count, _mm512_maskz_compress_ps(seen.inside, seen.x[d]));
  _mm512_storeu_si512(out.place + out.count,
                      _mm512_maskz_compress_epi32(seen.inside, numbers_from(first)));
  out.count += __builtin_popcount(seen.inside);
}

// Those of the candidates first, first + 1, ... of which the measure is at most the limit.
inline void take(const Floats& measure, float limit, std::int64_t first, std::int64_t left,
                 NearArrays& out) {
  const auto value = static_cast<__m512>(measure);
  const __mmask16 near =
      _mm512_mask_cmp_ps_mask(first_lanes(left), value, _mm512_set1_ps(limit), _CMP_LE_OQ);
  _mm512_storeu_ps(out.measure + out.count, _mm512_maskz_compress_ps(near, value));
  _mm512_storeu_si512(out.candidate + out.count,
                      _mm512_maskz_compress_epi32(near, numbers_from(first)));
  out.count += __builtin_popcount(near);
}

inline void put(const NearArrays& from, std::int64_t i, __mmask16 kept, NearArrays& out) {
  _mm512_storeu_ps(out.measure + out.count,
                   _mm512_maskz_compress_ps(kept, _mm512_loadu_ps(from.measure + i)));
  _mm512_storeu_si512(out.candidate + out.count,
                      _mm512_maskz_compress_epi32(kept, _mm512_loadu_si512(from.candidate + i)));
  out.count += __builtin_popcount(kept);
}

// Those that measure at most the limit, and the others.
inline void part(const NearArrays& near, float limit, NearArrays& low, NearArrays& high) {
  for (std::int64_t i = 0; i < near.count; i += lanes) {
    const __mmask16 there = first_lanes(near.count - i);
    const __mmask16 below = _mm512_mask_cmp_ps_mask(there, _mm512_loadu_ps(near.measure + i),
                                                    _mm512_set1_ps(limit), _CMP_LE_OQ);
    put(near, i, below, low);
    put(near, i, static_cast<__mmask16>(there & ~below), high);
  }
}

// Adds those of which the rank is smaller than `end` to `chosen`, and their ranks and `more` to
// all_ranks[chosen.count], which may lie before `rank`, but not behind.
inline Smallest add_ranked(const NearArrays& near, const float* rank, float end, float more,
                           float* all_ranks, NearArrays& chosen) {
  __m512 largest = _mm512_setzero_ps(),
         next = _mm512_set1_ps(std::numeric_limits<float>::infinity());
  for (std::int64_t i = 0; i < near.count; i += lanes) {
    const __mmask16 there = first_lanes(near.count - i);
    const __m512 ranked = _mm512_loadu_ps(rank + i), measure = _mm512_loadu_ps(near.measure + i);
    const __mmask16 kept = _mm512_mask_cmp_ps_mask(there, ranked, _mm512_set1_ps(end), _CMP_LT_OQ);
    largest = _mm512_mask_max_ps(largest, kept, largest, measure);
    next = _mm512_mask_min_ps(next, static_cast<__mmask16>(there & ~kept), next, measure);
    _mm512_storeu_ps(all_ranks + chosen.count,
                     _mm512_maskz_compress_ps(kept, _mm512_add_ps(ranked, _mm512_set1_ps(more))));
    put(near, i, kept, chosen);
  }
  return {chosen.count, _mm512_reduce_max_ps(largest), _mm512_reduce_min_ps(next), 0};
}

// As rank_smallest(), of at most so many vectors, all in registers: what is stored would have to
// reach the cache before it is read as other vectors. With `ranks`, in order, but no ranks without.
template <int vectors, bool ranks>
inline Smallest rank_in_registers(const NearArrays& near, std::int64_t k, float* rank,
                                  NearArrays& chosen, const FarArrays& far) {
  const __m512 infinity = _mm512_set1_ps(std::numeric_limits<float>::infinity());
  const __m512i one = _mm512_set1_epi32(1);
  __m512 measure[vectors];
  __m512i smaller[vectors];
  for (int v = 0; v < vectors; ++v) {
    measure[v] = _mm512_mask_loadu_ps(infinity, first_lanes(near.count - v * lanes),
                                      near.measure + v * lanes);
    smaller[v] = _mm512_setzero_si512();
  }
  for (std::int64_t j = 0; j < near.count; ++j) {
    const __m512 other = _mm512_set1_ps(near.measure[j]);
    for (int v = 0; v < vectors; ++v)
      smaller[v] = _mm512_mask_add_epi32(
          smaller[v], _mm512_cmp_ps_mask(other, measure[v], _CMP_LT_OQ), smaller[v], one);
  }
  __mmask16 kept[vectors];
  __m512 largest = _mm512_setzero_ps(), next = infinity;
  const __m512i end = _mm512_set1_epi32(static_cast<int>(k));
  for (int v = 0; v < vectors; ++v) {
    const __mmask16 there = first_lanes(near.count - v * lanes);
    kept[v] = _mm512_mask_cmp_epi32_mask(there, smaller[v], end, _MM_CMPINT_LT);
    largest = _mm512_mask_max_ps(largest, kept[v], largest, measure[v]);
    next = _mm512_mask_min_ps(next, static_cast<__mmask16>(~kept[v]), next, measure[v]);
  }
  Smallest result{0, _mm512_reduce_max_ps(largest), _mm512_reduce_min_ps(next), 0};
  const __m512 from = _mm512_set1_ps(far_from(result.largest, far.slack));
  for (int v = 0; v < vectors; ++v) {
    const __m512i candidate = _mm512_loadu_si512(near.candidate + v * lanes);
    _mm512_storeu_ps(chosen.measure + result.count, _mm512_maskz_compress_ps(kept[v], measure[v]));
    _mm512_storeu_si512(chosen.candidate + result.count,
                        _mm512_maskz_compress_epi32(kept[v], candidate));
    if constexpr (ranks)
      _mm512_storeu_ps(rank + result.count,
                       _mm512_maskz_compress_ps(kept[v], _mm512_cvtepi32_ps(smaller[v])));
    const __mmask16 beyond = _mm512_mask_cmp_ps_mask(kept[v], measure[v], from, _CMP_GE_OQ);
    _mm512_storeu_si512(far.candidate + result.far, _mm512_maskz_compress_epi32(beyond, candidate));
    result.count += __builtin_popcount(kept[v]);
    result.far += __builtin_popcount(beyond);
  }
  chosen.count = result.count;
  return result;
}

// Few enough for that?
inline bool fit_registers(const NearArrays& near) {
  return near.count <= 4 * lanes;
}
template <bool ranks>
inline Smallest rank_few(const NearArrays& near, std::int64_t k, float* rank, NearArrays& chosen,
                         const FarArrays& far) {
  if (near.count <= lanes) return rank_in_registers<1, ranks>(near, k, rank, chosen, far);
  if (near.count <= 2 * lanes) return rank_in_registers<2, ranks>(near, k, rank, chosen, far);
  return rank_in_registers<4, ranks>(near, k, rank, chosen, far);
}
#else
template <int D>
struct InBox {
  float x[D][lanes];
  bool inside[lanes];
};

template <class S, int D>
inline InBox<D> look_at(const CellView<S>& cells, const CellBox<S>& box, std::int64_t first,
                        std::int64_t left) {
  InBox<D> seen;
  for (int l = 0; l < lanes; ++l) seen.inside[l] = l < left;
  for (int d = 0; d < D; ++d)
    for (int l = 0; l < lanes; ++l) {
      const auto x = static_cast<float>(cells.x[d][first + l] - box.centre[d]);
      seen.inside[l] &= (x >= box.lower[d]) & (x <= box.upper[d]);
      seen.x[d][l] = x;
    }
  return seen;
}

template <int D>
inline void add(const InBox<D>& seen, std::int64_t first, CandidateArrays& out) {
  for (int l = 0; l < lanes; ++l) {  // always written, counted if inside
    for (int d = 0; d < D; ++d) out.x[d][out.count] = seen.x[d][l];
    out.place[out.count] = static_cast<std::uint32_t>(first + l);
    out.count += seen.inside[l];
  }
}

inline void take(const Floats& measure, float limit, std::int64_t first, std::int64_t left,
                 NearArrays& out) {
  if (stdx::none_of(measure <= Floats(limit))) return;
  float measures[lanes];
  measure.copy_to(measures, stdx::element_aligned);
  const std::int64_t there = left < lanes ? left : lanes;
  for (std::int64_t l = 0; l < there; ++l) {
    out.measure[out.count] = measures[l];
    out.candidate[out.count] = static_cast<std::uint32_t>(first + l);
    out.count += measures[l] <= limit;
  }
}

inline void part(const NearArrays& near, float limit, NearArrays& low, NearArrays& high) {
  for (std::int64_t i = 0; i < near.count; ++i) {
    const bool below = near.measure[i] <= limit;
    low.measure[low.count] = high.measure[high.count] = near.measure[i];
    low.candidate[low.count] = high.candidate[high.count] = near.candidate[i];
    low.count += below;
    high.count += !below;
  }
}

inline Smallest add_ranked(const NearArrays& near, const float* rank, float end, float more,
                           float* all_ranks, NearArrays& chosen) {
  Smallest result{0, 0, std::numeric_limits<float>::infinity(), 0};
  for (std::int64_t i = 0; i < near.count; ++i) {
    const float measure = near.measure[i];
    const bool kept = rank[i] < end;
    result.largest = kept && measure > result.largest ? measure : result.largest;
    result.next = !kept && measure < result.next ? measure : result.next;
    chosen.measure[chosen.count] = measure;
    chosen.candidate[chosen.count] = near.candidate[i];
    all_ranks[chosen.count] = rank[i] + more;
    chosen.count += kept;
  }
  result.count = chosen.count;
  return result;
}

inline bool fit_registers(const NearArrays&) {
  return false;
}
template <bool ranks>
inline Smallest rank_few(const NearArrays&, std::int64_t, float*, NearArrays&, const FarArrays&) {
  return {};
}
#endif

// Where the next ones are written depends on how many there were before. Several vectors are looked
// at before any is written, so that the processor need not wait for that with the next ones.
constexpr int together = 4;

// Vectors of particles still to be looked at. They are listed first and looked at together, because
// how many there are in a row cannot be predicted: the processor would guess wrong in every row.
struct Vectors {
  static constexpr int most = 96;
  int count = 0;
  std::int64_t first[most + together], left[most + together];

  // If the condition holds; without a branch.
  void add_if(bool condition, std::int64_t at, std::int64_t particles) {
    first[count] = at;
    left[count] = particles;
    count += condition;
  }
};

template <class S, int D>
inline void collect_listed(const CellView<S>& cells, const CellBox<S>& box, Vectors& listed,
                           CandidateArrays& out) {
  CandidateArrays found = out;  // in registers
  for (int v = 0; v < together; ++v)
    listed.first[listed.count + v] = listed.left[listed.count + v] = 0;
  for (int v = 0; v < listed.count; v += together) {
    InBox<D> seen[together];
    for (int i = 0; i < together; ++i)
      seen[i] = look_at<S, D>(cells, box, listed.first[v + i], listed.left[v + i]);
    for (int i = 0; i < together; ++i) add<D>(seen[i], listed.first[v + i], found);
  }
  out.count = found.count;
  listed.count = 0;
}

template <int D, bool cube>
inline void near_points(const CandidateArrays& from, std::int64_t begin, std::int64_t end,
                        const float* x, float limit, NearArrays& out) {
  NearArrays found = out;  // in registers, as the others
  const float* candidates[D];
  Floats at[D];
  for (int d = 0; d < D; ++d) {
    candidates[d] = from.x[d];
    at[d] = Floats(x[d]);
  }
  for (std::int64_t c = begin; c < end; c += together * lanes) {
    Floats measure[together];
    for (int i = 0; i < together; ++i)
      for (int d = 0; d < D; ++d) {
        const Floats gap = at[d] - Floats(candidates[d] + c + i * lanes, stdx::element_aligned);
        if (cube) {
          const Floats size = select(gap > Floats(0.0f), gap, -gap);
          measure[i] = d == 0 ? size : select(size > measure[i], size, measure[i]);
        } else {
          measure[i] = d == 0 ? gap * gap : measure[i] + gap * gap;
        }
      }
    for (int i = 0; i < together; ++i)
      take(measure[i], limit, c + i * lanes, end - c - i * lanes, found);
  }
  out.count = found.count;
}

// Of `vectors` vectors of values from `begin` on.
template <class T, int vectors>
inline void rank_some(const T* values, std::int64_t count, std::int64_t begin, T* rank) {
  using P = Pack<T>;
  constexpr int width = LaneTraits<P>::lanes;
  P own[vectors], smaller_ones[vectors];
  for (int v = 0; v < vectors; ++v) {
    own[v].copy_from(values + begin + v * width, stdx::element_aligned);
    smaller_ones[v] = P(T(0));
  }
  for (std::int64_t j = 0; j < count; ++j) {
    const P other(values[j]);
    for (int v = 0; v < vectors; ++v) smaller_ones[v] += select(other < own[v], P(T(1)), P(T(0)));
  }
  for (int v = 0; v < vectors; ++v)
    smaller_ones[v].copy_to(rank + begin + v * width, stdx::element_aligned);
}

}  // namespace

template <class S, int D>
CollectResult collect(const CellView<S>& cells, const CellBox<S>& box, CandidateArrays& out) {
  const std::int64_t start = out.count;
  std::int64_t particles = 0;  // in the stretches so far: at most so many are in the box
  Vectors listed;
  for (std::int64_t low = box.from[1]; low <= box.to[1];) {
    const std::int64_t border = (low / rows_of_a_band + 1) * rows_of_a_band;
    const std::int64_t high = border < box.to[1] + 1 ? border : box.to[1] + 1;
    for (std::int64_t k = box.from[2]; k <= box.to[2]; ++k)
      for (std::int64_t j = low; j < high; ++j) {
        const std::int64_t row = row_of_cells(cells.counts, j, k);
        const std::int64_t first = cells.first[row + box.from[0]];
        const std::int64_t length = cells.first[row + box.to[0] + 1] - first;
        particles += length;
        out.work += work_of_a_row + length;
        if (out.work > out.work_limit) return CollectResult::too_much_work;
        if (start + particles > out.capacity) return CollectResult::no_room;
        listed.add_if(length > 0, first, length);
        listed.add_if(length > lanes, first + lanes, length - lanes);
        for (std::int64_t done = 2 * lanes; done < length; done += lanes) {
          if (listed.count > Vectors::most - 3) collect_listed<S, D>(cells, box, listed, out);
          listed.add_if(true, first + done, length - done);
        }
        if (listed.count > Vectors::most - 3) collect_listed<S, D>(cells, box, listed, out);
      }
    low = high;
  }
  collect_listed<S, D>(cells, box, listed, out);
  return CollectResult::complete;
}

template <int D>
void near_ball(const CandidateArrays& from, std::int64_t begin, std::int64_t end, const float* x,
               float limit, NearArrays& out) {
  near_points<D, false>(from, begin, end, x, limit, out);
}

template <int D>
void near_cube(const CandidateArrays& from, std::int64_t begin, std::int64_t end, const float* x,
               float limit, NearArrays& out) {
  near_points<D, true>(from, begin, end, x, limit, out);
}

template <class T>
void ranks(T* values, std::int64_t count, T* rank) {
  constexpr int width = LaneTraits<Pack<T>>::lanes;
  for (int l = 0; l < 4 * width; ++l) values[count + l] = T(0);  // ranked, and not looked at
  std::int64_t begin = 0;
  for (; count - begin > 2 * width; begin += 4 * width) rank_some<T, 4>(values, count, begin, rank);
  if (count - begin > width)
    rank_some<T, 2>(values, count, begin, rank);
  else if (count > begin)
    rank_some<T, 1>(values, count, begin, rank);
}

namespace {

// Adds those of the chosen that are nearly the farthest.
Smallest with_far(Smallest result, const NearArrays& chosen, const FarArrays& far) {
  const float from = far_from(result.largest, far.slack);
  for (std::int64_t i = 0; i < chosen.count; ++i) {  // without a branch that depends on the data
    far.candidate[result.far] = chosen.candidate[i];
    result.far += chosen.measure[i] >= from;
  }
  return result;
}

// All ranked, in order.
Smallest rank_all(const NearArrays& near, std::int64_t k, float* rank, NearArrays& chosen) {
  ranks(near.measure, near.count, rank);
  chosen.count = 0;
  return add_ranked(near, rank, static_cast<float>(k), 0, rank, chosen);
}

}  // namespace

Smallest rank_smallest(const NearArrays& near, std::int64_t k, float probably, NearArrays& rest,
                       float* rank, NearArrays& chosen, const FarArrays& far) {
  if (fit_registers(near)) return rank_few<true>(near, k, rank, chosen, far);
  chosen.count = rest.count = 0;
  part(near, probably, chosen, rest);
  if (chosen.count >= k) return with_far(rank_all(near, k, rank, chosen), chosen, far);
  const std::int64_t low = chosen.count;
  ranks(chosen.measure, low, rank);
  ranks(rest.measure, rest.count, rank + low);
  const Smallest result = add_ranked(rest, rank + low, static_cast<float>(k - low),
                                     static_cast<float>(low), rank, chosen);
  return with_far(result, chosen, far);
}

Smallest select_smallest(const NearArrays& near, std::int64_t k, float probably, NearArrays& rest,
                         float* rank, NearArrays& chosen, const FarArrays& far) {
  if (fit_registers(near)) return rank_few<false>(near, k, rank, chosen, far);
  chosen.count = rest.count = 0;
  part(near, probably, chosen, rest);
  if (chosen.count >= k) return with_far(rank_all(near, k, rank, chosen), chosen, far);
  const std::int64_t low = chosen.count;
  ranks(rest.measure, rest.count, rank);
  chosen.count = 0;
  Smallest result = add_ranked(rest, rank, static_cast<float>(k - low), 0, rank, chosen);
  chosen.count = rest.count = 0;
  part(near, result.largest, chosen, rest);  // in order
  result.count = chosen.count;
  return with_far(result, chosen, far);
}

std::int64_t count_at_most(const float* values, std::int64_t count, float limit) {
  std::int64_t all = 0;
  for (std::int64_t i = 0; i < count; i += lanes) {
    const int there = static_cast<int>(count - i < lanes ? count - i : lanes);
    int here = 0;
    for (int l = 0; l < there; ++l) here += values[i + l] <= limit;
    all += here;
  }
  return all;
}

#define RECON_INSTANTIATE(S, D) \
  template CollectResult collect<S, D>(const CellView<S>&, const CellBox<S>&, CandidateArrays&)
RECON_FOR_EACH_SCALAR_AND_DIMENSION(RECON_INSTANTIATE);
#undef RECON_INSTANTIATE
#define RECON_INSTANTIATE(D)                                                                   \
  template void near_ball<D>(const CandidateArrays&, std::int64_t, std::int64_t, const float*, \
                             float, NearArrays&);                                              \
  template void near_cube<D>(const CandidateArrays&, std::int64_t, std::int64_t, const float*, \
                             float, NearArrays&)
RECON_INSTANTIATE(1);
RECON_INSTANTIATE(2);
RECON_INSTANTIATE(3);
#undef RECON_INSTANTIATE
template void ranks<float>(float*, std::int64_t, float*);
template void ranks<double>(double*, std::int64_t, double*);
template void ranks<std::uint32_t>(std::uint32_t*, std::int64_t, std::uint32_t*);

}  // namespace recon::detail::RECON_SET
