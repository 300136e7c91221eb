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
  // += factor * other
  inline void add(double factor, const Four& other) {
    for (int i = 0; i < parts; ++i) part[i] += factor * other.part[i];
  }
};
constexpr double zeros[4] = {0, 0, 0, 0};

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

}  // namespace

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

#define RECON_INSTANTIATE(D)                                     \
  template void give<D>(const NodeList&, const Given&, double*); \
  template void take<D>(const NodeList&, const double*, const double*, std::ptrdiff_t, Taken&)
RECON_INSTANTIATE(1);
RECON_INSTANTIATE(2);
RECON_INSTANTIATE(3);
#undef RECON_INSTANTIATE

}  // namespace recon::detail::RECON_SET
