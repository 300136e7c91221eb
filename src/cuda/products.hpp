// Products of operators with fields: the functors, one thread for each row or column.
#pragma once

#include "cuda/neighbours.hpp"
#include "recon/core/sums.hpp"
#include "recon/local_solve/report.hpp"

namespace recon::cuda {

// out(t, c * blocks + b) = sum_e value(e, b) in(column(e), c) for the entries e of row t; `empty`
// where the target of the row has no support.
template <class T>
struct Apply {
  const std::int64_t* offsets;
  const std::uint32_t *columns, *target_of;
  const FitReport* reports;
  const T* values;
  int blocks;
  Field<const T> in;
  Field<T> out;
  T empty;

  RECON_DEVICE void operator()(std::size_t row) const {
    const std::uint32_t t = target_of[row];
    const std::int64_t first = offsets[row], count = offsets[row + 1] - first;
    const FitStatus status = reports[t].status;
    const bool none_there = status == FitStatus::no_support || status == FitStatus::too_far;
    for (int c = 0; c < in.components; ++c)
      for (int b = 0; b < blocks; ++b) {
        T sum = empty;
        if (!none_there)
          sum = detail::sum_of<T>(count, [&](std::int64_t e) {
            return values[(first + e) * blocks + b] *
                   in.data[columns[first + e] * in.point_stride + c * in.component_stride];
          });
        out.data[t * out.point_stride + (c * blocks + b) * out.component_stride] = sum;
      }
  }
};

// The transpose, by columns: out(p, c) = sum_e sum_b value(e, b) in(target(e), c * blocks + b) for
// the entries e of column p, which stand in `entries` in ascending order.
template <class T>
struct ApplyTransposed {
  const std::uint32_t *first, *entries, *row_of, *target_of;
  const T* values;
  int blocks;
  Field<const T> in;
  Field<T> out;

  RECON_DEVICE void operator()(std::size_t p) const {
    const std::uint32_t begin = first[p];
    const auto count = static_cast<std::int64_t>(first[p + 1] - begin);
    for (int c = 0; c < out.components; ++c) {
      const T sum = detail::sum_of<T>(count, [&](std::int64_t i) {
        const std::size_t e = entries[begin + i];
        const T* const from =
            in.data + target_of[row_of[e]] * in.point_stride + c * blocks * in.component_stride;
        T part = 0;
        for (int b = 0; b < blocks; ++b)
          part += values[e * static_cast<std::size_t>(blocks) + static_cast<std::size_t>(b)] *
                  from[b * in.component_stride];
        return part;
      });
      out.data[static_cast<std::ptrdiff_t>(p) * out.point_stride + c * out.component_stride] = sum;
    }
  }
};

// The row of each entry, and the caller's number of its particle; what lies behind the last entry
// counts to no particle. Run for 0 <= row <= rows.
struct NameEntries {
  const std::int64_t* offsets;
  std::size_t rows;
  const std::uint32_t *places, *order;
  std::uint32_t *columns, *row_of;  // row_of: null where nobody asks

  RECON_DEVICE void operator()(std::size_t row) const {
    for (std::int64_t e = offsets[row]; e < offsets[row + 1]; ++e) {
      if (columns) columns[e] = order[places[e]];
      if (row_of) row_of[e] = static_cast<std::uint32_t>(row);
    }
  }
};
// Keys and numbers of entries, to be sorted by column; what lies behind the last gets `behind`.
struct KeyEntries {
  const std::int64_t* total;
  const std::uint32_t* columns;
  std::uint32_t behind;
  std::uint32_t *key, *entry;

  RECON_DEVICE void operator()(std::size_t e) const {
    key[e] = static_cast<std::int64_t>(e) < *total ? columns[e] : behind;
    entry[e] = static_cast<std::uint32_t>(e);
  }
};

}  // namespace recon::cuda
