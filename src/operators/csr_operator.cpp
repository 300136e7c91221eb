#include "recon/operators/csr_operator.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>

#include "recon/core/error.hpp"
#include "recon/core/parallel.hpp"
#include "recon/core/sums.hpp"
#include "recon/points/make_view.hpp"

namespace recon {
namespace {

using detail::require;

constexpr std::size_t rows_per_block = 1024;

// The field as one array in the order of `point_of` (empty: its own), point-major, checked to be
// finite. Places in `skip` (ascending) are zeroed instead.
template <class Scalar>
Array<Scalar> gather(const FieldView<Scalar>& field, std::span<const std::uint32_t> point_of,
                     std::span<const std::uint32_t> skip, int threads) {
  const int components = field.components();
  Array<Scalar> values(field.size() * static_cast<std::size_t>(components));
  parallel_blocks(
      field.size(), 16 * rows_per_block, threads, [&](std::size_t begin, std::size_t end) {
        auto skipped = std::lower_bound(skip.begin(), skip.end(), begin);
        Scalar* to = values.data() + begin * static_cast<std::size_t>(components);
        for (std::size_t i = begin; i < end; ++i) {
          const bool skips = skipped != skip.end() && *skipped == i;
          skipped += skips;
          const std::size_t point = point_of.empty() ? i : point_of[i];
          for (int c = 0; c < components; ++c) {
            const Scalar value = skips ? Scalar(0) : field(point, c);
            if (!std::isfinite(value)) [[unlikely]]
              detail::throw_invalid("component " + std::to_string(c) + " of the field at point " +
                                        std::to_string(point),
                                    value, "must be finite");
            *to++ = value;
          }
        }
      });
  return values;
}

// sums[c * B + b] = sum over these entries of a row of value(e, b) in(index(e), first + c), c < C.
template <int B, int C, class Scalar>
void block_sums(const Scalar* values, const ParticleIndex* indices, std::int64_t begin,
                std::int64_t end, const Scalar* in, std::size_t stride, Scalar* sums) {
  // Several partial sums: one alone would wait for each addition before the next can begin.
  constexpr int parts = B * C <= 2 ? 4 : B * C <= 4 ? 2 : 1;
  Scalar total[parts][B * C] = {};
  const auto add = [&](std::int64_t e, Scalar* to) {
    const Scalar* u = in + indices[e] * stride;
    for (int c = 0; c < C; ++c)
      for (int b = 0; b < B; ++b) to[c * B + b] += values[e * B + b] * u[c];
  };
  std::int64_t e = begin;
  for (; e + parts <= end; e += parts)
    for (int i = 0; i < parts; ++i) add(e + i, total[i]);
  for (; e < end; ++e) add(e, total[0]);
  for (int i = 1; i < parts; ++i)
    for (int j = 0; j < B * C; ++j) total[0][j] += total[i][j];
  std::copy(total[0], total[0] + B * C, sums);
}

template <int B, int C, class Scalar>
void row_sums(const Scalar* values, const ParticleIndex* indices, std::int64_t begin,
              std::int64_t end, const Scalar* in, std::size_t stride, Scalar* sums) {
  if (end - begin <= detail::sum_block) [[likely]]
    return block_sums<B, C>(values, indices, begin, end, in, stride, sums);
  detail::add_many_blocks<B * C>(
      end - begin, sums, [&](std::int64_t from, std::int64_t to, Scalar* part) {
        block_sums<B, C>(values, indices, begin + from, begin + to, in, stride, part);
      });
}

template <int B, class Scalar>
void row_sums(int components, const Scalar* values, const ParticleIndex* indices,
              std::int64_t begin, std::int64_t end, const Scalar* in, Scalar* sums) {
  const auto stride = static_cast<std::size_t>(components);
  int c = 0;
  for (; c + 4 <= components; c += 4)
    row_sums<B, 4>(values, indices, begin, end, in + c, stride, sums + c * B);
  if (components - c == 3)
    row_sums<B, 3>(values, indices, begin, end, in + c, stride, sums + c * B);
  if (components - c == 2)
    row_sums<B, 2>(values, indices, begin, end, in + c, stride, sums + c * B);
  if (components - c == 1)
    row_sums<B, 1>(values, indices, begin, end, in + c, stride, sums + c * B);
}

// One test for all: x - x is 0 for numbers and NaN for others.
template <class Scalar>
bool all_finite(const Scalar* sums, int count) {
  Scalar zero = 0;
  for (int i = 0; i < count; ++i) zero += sums[i] - sums[i];
  return zero == 0;
}

// Sums that have left the range of numbers are formed again: sum_of_products(i) is scaled sum
// number i. Finite data can have a result that is too large by itself; then this says where.
template <class Scalar, class SumOfProducts>
[[gnu::noinline]] void mend_overflow(Scalar* sums, int count, const char* place, std::size_t number,
                                     const SumOfProducts& sum_of_products) {
  for (int i = 0; i < count; ++i) {
    if (std::isfinite(sums[i])) continue;
    sums[i] = sum_of_products(i);
    if (!std::isfinite(sums[i]))
      detail::throw_invalid(
          "component " + std::to_string(i) + " of the result at " + place + std::to_string(number),
          sums[i], "overflows: the data, or the inverse of a support, are too large");
  }
}

// Limits the values of a row, one for each component; returns how many left the range of the data
// by more than rounding.
template <class Scalar>
std::uint32_t limit_row(const Scalar* phi, const ParticleIndex* indices, std::int64_t begin,
                        std::int64_t end, const Scalar* in, std::size_t components, Limit kind,
                        const std::vector<detail::DataRange<Scalar>>& all, Scalar* values) {
  std::uint32_t limited = 0;
  for (std::size_t c = 0; c < components; ++c) {
    detail::DataRange<Scalar> range;
    // Most values lie between the data of the first few particles.
    for (std::int64_t e = begin; e < end && !range.holds(values[c]); ++e)
      if (phi[e] != 0) range.add(in[indices[e] * components + c]);
    if (range.holds(values[c])) continue;
    Scalar amplification = 0;
    for (std::int64_t e = begin; e < end; ++e) amplification += std::abs(phi[e]);
    limited += range.limit(values[c], kind, all[c], amplification);
  }
  return limited;
}

// The ranges of the components of `in`.
template <class Scalar>
std::vector<detail::DataRange<Scalar>> ranges_of(const Array<Scalar>& in, std::size_t components) {
  std::vector<detail::DataRange<Scalar>> ranges(components);
  for (std::size_t i = 0; i < in.size(); ++i) ranges[i % components].add(in[i]);
  return ranges;
}

}  // namespace

template <class Scalar>
std::size_t SparsityPattern<Scalar>::row(std::size_t target) const {
  if (target_of.empty()) return target;
  std::call_once(once_row_of_, [this] {
    std::vector<std::uint32_t> places(target_of.size());
    for (std::size_t i = 0; i < places.size(); ++i)
      places[target_of[i]] = static_cast<std::uint32_t>(i);
    row_of_ = std::move(places);
  });
  return row_of_[target];
}

template <class Scalar>
const typename SparsityPattern<Scalar>::Transposed& SparsityPattern<Scalar>::transposed() const {
  std::call_once(once_transposed_, [this] {
    const Array<ParticleIndex>& indices = neighbours.indices;
    Transposed t;
    t.offsets.assign(columns + 1, 0);
    for (const ParticleIndex p : indices) ++t.offsets[p + 1];
    for (std::size_t p = 0; p < columns; ++p) t.offsets[p + 1] += t.offsets[p];
    t.entries.resize(indices.size());
    t.rows.resize(indices.size());
    std::vector<std::int64_t> next(t.offsets.begin(), t.offsets.end() - 1);
    for (std::size_t row = 0; row < rows(); ++row)
      for (std::int64_t e = neighbours.offsets[row]; e < neighbours.offsets[row + 1]; ++e) {
        const std::int64_t at = next[indices[e]]++;
        t.entries[at] = e;
        t.rows[at] = static_cast<std::uint32_t>(row);
      }
    transposed_ = std::move(t);
  });
  return transposed_;
}

template <class Scalar>
CsrOperator<Scalar>::CsrOperator(std::shared_ptr<const SparsityPattern<Scalar>> pattern,
                                 Array<Scalar> values, int blocks, Scalar fill, int threads)
    : pattern_(std::move(pattern)),
      values_(std::move(values)),
      blocks_(blocks),
      fill_(fill),
      threads_(threads) {
  require(values_.size() == pattern_->neighbours.indices.size() * static_cast<std::size_t>(blocks),
          "values of the operator", values_.size(), "must be blocks numbers per entry");
}

template <class Scalar>
std::vector<std::uint32_t> CsrOperator<Scalar>::empty_rows() const {
  std::vector<std::uint32_t> targets;
  for (const std::uint32_t row : pattern_->empty_rows)
    targets.push_back(static_cast<std::uint32_t>(pattern_->target(row)));
  std::sort(targets.begin(), targets.end());
  return targets;
}

template <class Scalar>
void CsrOperator<Scalar>::apply(const FieldView<Scalar>& field,
                                const FieldSpan<Scalar>& out) const {
  apply(field, out, Limit::none, nullptr);
}

template <class Scalar>
void CsrOperator<Scalar>::apply(const FieldView<Scalar>& field, const FieldSpan<Scalar>& out,
                                Limit limit, std::uint32_t* limited) const {
  require(field.size() == columns(), "size of the field", field.size(),
          "must be the number of particles");
  require(out.size() == rows(), "size of the output", out.size(), "must be the number of targets");
  const int width = field.components() * blocks_;
  require(out.components() == width, "components of the output", out.components(),
          "must be those of the field times the operator's blocks");
  const SparsityPattern<Scalar>& pattern = *pattern_;
  const Array<Scalar> in = gather<Scalar>(field, pattern.particle_of, {}, threads_);
  std::vector<detail::DataRange<Scalar>> all;
  if (limit != Limit::none) all = ranges_of(in, static_cast<std::size_t>(width));

  parallel_blocks(rows(), rows_per_block, threads_, [&](std::size_t begin, std::size_t end) {
    std::vector<Scalar> sums(width);
    auto empty = std::lower_bound(pattern.empty_rows.begin(), pattern.empty_rows.end(), begin);
    for (std::size_t row = begin; row < end; ++row) {
      const std::size_t t = pattern.target(row);
      if (empty != pattern.empty_rows.end() && *empty == row) {
        ++empty;
        for (int i = 0; i < width; ++i) out(t, i) = fill_;
        continue;
      }
      const std::int64_t first = pattern.neighbours.offsets[row],
                         last = pattern.neighbours.offsets[row + 1];
      const Scalar* values = values_.data();
      const ParticleIndex* index = pattern.neighbours.indices.data();
      switch (blocks_) {
        case 1:
          row_sums<1>(field.components(), values, index, first, last, in.data(), sums.data());
          break;
        case 2:
          row_sums<2>(field.components(), values, index, first, last, in.data(), sums.data());
          break;
        case 3:
          row_sums<3>(field.components(), values, index, first, last, in.data(), sums.data());
          break;
        default:
          row_sums<6>(field.components(), values, index, first, last, in.data(), sums.data());
          break;
      }
      if (!all_finite(sums.data(), width)) [[unlikely]]
        mend_overflow(sums.data(), width, "target ", t, [&](int i) {
          const auto stride = static_cast<std::size_t>(field.components());
          return detail::scaled_sum_of_products<Scalar>(
              last - first,
              [&](std::int64_t e) { return values[(first + e) * blocks_ + i % blocks_]; },
              [&](std::int64_t e) { return in[index[first + e] * stride + i / blocks_]; });
        });
      if (limit != Limit::none)
        limited[t] = limit_row(values, index, first, last, in.data(),
                               static_cast<std::size_t>(width), limit, all, sums.data());
      for (int i = 0; i < width; ++i) out(t, i) = sums[i];
    }
  });
}

template <class Scalar>
void CsrOperator<Scalar>::apply_transpose(const FieldView<Scalar>& field,
                                          const FieldSpan<Scalar>& out) const {
  require(field.size() == rows(), "size of the field", field.size(),
          "must be the number of targets");
  require(field.components() % blocks_ == 0, "components of the field", field.components(),
          "must be a multiple of the operator's blocks");
  const int components = field.components() / blocks_;
  require(out.size() == columns(), "size of the output", out.size(),
          "must be the number of particles");
  require(out.components() == components, "components of the output", out.components(),
          "must be those of the field divided by the operator's blocks");
  const SparsityPattern<Scalar>& pattern = *pattern_;
  const Array<Scalar> in = gather<Scalar>(field, pattern.target_of, pattern.empty_rows, threads_);
  const auto& columns_of = pattern.transposed();
  const auto stride = static_cast<std::size_t>(field.components());

  parallel_blocks(columns(), rows_per_block, threads_, [&](std::size_t begin, std::size_t end) {
    std::vector<Scalar> sums(components), part(components), lost(components);
    const auto add = [&](std::int64_t from, std::int64_t to, std::vector<Scalar>& total) {
      for (std::int64_t i = from; i < to; ++i) {
        const Scalar* value = values_.data() + columns_of.entries[i] * blocks_;
        const Scalar* f = in.data() + columns_of.rows[i] * stride;
        for (int c = 0; c < components; ++c)
          for (int b = 0; b < blocks_; ++b) total[c] += value[b] * f[c * blocks_ + b];
      }
    };
    for (std::size_t column = begin; column < end; ++column) {
      const std::int64_t first = columns_of.offsets[column], last = columns_of.offsets[column + 1];
      std::int64_t next = std::min<std::int64_t>(last, first + detail::sum_block);
      std::fill(sums.begin(), sums.end(), Scalar(0));
      add(first, next, sums);
      if (next < last) {  // as in add_in_blocks, for a number of sums that is known here only
        std::fill(lost.begin(), lost.end(), Scalar(0));
        while (next < last) {
          const std::int64_t from = next;
          next = std::min<std::int64_t>(last, from + detail::sum_block);
          std::fill(part.begin(), part.end(), Scalar(0));
          add(from, next, part);
          for (int c = 0; c < components; ++c)
            detail::add_keeping_rounding(part[c], sums[c], lost[c]);
        }
        for (int c = 0; c < components; ++c) sums[c] += lost[c];
      }
      const ParticleIndex p = pattern.particle(column);
      if (!all_finite(sums.data(), components)) [[unlikely]]
        mend_overflow(sums.data(), components, "particle ", p, [&](int c) {
          return detail::scaled_sum_of_products<Scalar>(
              (last - first) * blocks_,
              [&](std::int64_t i) {
                return values_[columns_of.entries[first + i / blocks_] * blocks_ + i % blocks_];
              },
              [&](std::int64_t i) {
                return in[columns_of.rows[first + i / blocks_] * stride +
                          static_cast<std::size_t>(c * blocks_ + i % blocks_)];
              });
        });
      for (int c = 0; c < components; ++c) out(p, c) = sums[c];
    }
  });
}

template <class Scalar>
typename CsrOperator<Scalar>::Matrix CsrOperator<Scalar>::apply(
    const FieldView<Scalar>& field) const {
  Matrix out(static_cast<Eigen::Index>(rows()), field.components() * blocks_);
  apply(field, field_of(out));
  return out;
}

template <class Scalar>
typename CsrOperator<Scalar>::Matrix CsrOperator<Scalar>::apply_transpose(
    const FieldView<Scalar>& field) const {
  require(field.components() % blocks_ == 0, "components of the field", field.components(),
          "must be a multiple of the operator's blocks");
  Matrix out(static_cast<Eigen::Index>(columns()), field.components() / blocks_);
  apply_transpose(field, field_of(out));
  return out;
}

template struct SparsityPattern<float>;
template struct SparsityPattern<double>;
template class CsrOperator<float>;
template class CsrOperator<double>;

}  // namespace recon
