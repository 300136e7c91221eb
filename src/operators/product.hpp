// The product of an operator and a field: how the numbers of a field are read, how rows are summed,
// checked and limited.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "recon/core/error.hpp"
#include "recon/core/parallel.hpp"
#include "recon/core/sums.hpp"
#include "recon/core/unroll.hpp"
#include "recon/operators/csr_operator.hpp"

namespace recon::detail {

[[noreturn]] inline void throw_not_finite(std::size_t point, int component, double value) {
  throw_invalid(
      "component " + std::to_string(component) + " of the field at point " + std::to_string(point),
      value, "must be finite");
}

// How sums read the components first, first + 1, ... of a field: u = at(particle), u[0], u[1], ...
//
// Of points whose components lie side by side, `stride` numbers from one point to the next.
template <class Scalar>
struct SideBySide {
  const Scalar* data;
  std::size_t stride;

  static bool reads(const FieldView<Scalar>& field) {
    constexpr auto size = static_cast<std::ptrdiff_t>(sizeof(Scalar));
    return !field.separate() && field.point_stride() % size == 0 &&
           (field.components() == 1 || field.component_stride() == size);
  }
  SideBySide(const FieldView<Scalar>& field, int first)
      : data(static_cast<const Scalar*>(field.first(first))),
        stride(static_cast<std::size_t>(field.point_stride()) / sizeof(Scalar)) {}
  const Scalar* at(ParticleIndex particle) const { return data + particle * stride; }
};

// Of C components side by side and nothing between the points.
template <class Scalar, int C>
struct Packed {
  const Scalar* data;
  const Scalar* at(ParticleIndex particle) const { return data + std::size_t{particle} * C; }
};

// Of any field: structs of arrays, for example.
template <class Scalar>
struct AnyLayout {
  const FieldView<Scalar>& field;
  int first;

  struct Values {
    const FieldView<Scalar>& field;
    ParticleIndex particle;
    int first;
    Scalar operator[](int c) const { return field(particle, first + c); }
  };
  Values at(ParticleIndex particle) const { return {field, particle, first}; }
};

// sums[c * B + b] = sum over these entries of a row of value(e, b) u(index(e), c), c < C.
//
// Of a long row several partial sums are formed: one alone would wait for each addition before the
// next can begin. Short rows wait for nothing, because the next row can begin.
template <int B, int C, int parts, class Scalar, class Field>
RECON_INLINE void plain_sums(const Scalar* values, const ParticleIndex* indices, std::int64_t begin,
                             std::int64_t end, const Field& field, Scalar* sums) {
  Scalar total[parts][B * C] = {};
  const auto add = [&](std::int64_t e, Scalar* to) RECON_INLINE_LAMBDA {
    const auto u = field.at(indices[e]);
    for (int c = 0; c < C; ++c)
      for (int b = 0; b < B; ++b) to[c * B + b] += values[e * B + b] * u[c];
  };
  std::int64_t e = begin;
  for (; e + parts <= end; e += parts)
    for (int i = 0; i < parts; ++i) add(e + i, total[i]);
  if constexpr (parts > 1)
    for (; e < end; ++e) add(e, total[0]);
  for (int i = 1; i < parts; ++i)
    for (int j = 0; j < B * C; ++j) total[0][j] += total[i][j];
  for (int j = 0; j < B * C; ++j) sums[j] = total[0][j];
}

// Of long rows, as a function of its own: the loops are compiled once for both uses.
template <int B, int C, class Scalar, class Field>
[[gnu::noinline]] void block_sums(const Scalar* values, const ParticleIndex* indices,
                                  std::int64_t begin, std::int64_t end, const Field& field,
                                  Scalar* sums) {
  plain_sums<B, C, (B * C <= 2 ? 4 : B * C <= 4 ? 2 : 1)>(values, indices, begin, end, field, sums);
}

template <int B, int C, class Scalar, class Field>
void long_row_sums(const Scalar* values, const ParticleIndex* indices, std::int64_t begin,
                   std::int64_t end, const Field& field, Scalar* sums) {
  if (end - begin <= sum_block) [[likely]]
    return block_sums<B, C>(values, indices, begin, end, field, sums);
  add_many_blocks<B * C>(end - begin, sums, [&](std::int64_t from, std::int64_t to, Scalar* part) {
    block_sums<B, C>(values, indices, begin + from, begin + to, field, part);
  });
}

template <int B, int C, class Scalar, class Field>
RECON_INLINE void row_sums(const Scalar* values, const ParticleIndex* indices, std::int64_t begin,
                           std::int64_t end, const Field& field, Scalar* sums) {
  constexpr std::int64_t short_row = 32;
  if (end - begin <= short_row)
    plain_sums<B, C, 1>(values, indices, begin, end, field, sums);
  else
    long_row_sums<B, C>(values, indices, begin, end, field, sums);
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
      throw_invalid(
          "component " + std::to_string(i) + " of the result at " + place + std::to_string(number),
          sums[i], "overflows: the data, or the inverse of a support, are too large");
  }
}

// Limits the values of a row, one for each component; returns how many left the range of the data
// by more than rounding.
template <class Scalar>
std::uint32_t limit_row(const Scalar* phi, const ParticleIndex* indices, std::int64_t begin,
                        std::int64_t end, const FieldView<Scalar>& in, Limit kind,
                        const std::vector<DataRange<Scalar>>& all, Scalar* values) {
  std::uint32_t limited = 0;
  for (int c = 0; c < in.components(); ++c) {
    DataRange<Scalar> range;
    // Most values lie between the data of the first few particles.
    for (std::int64_t e = begin; e < end && !range.holds(values[c]); ++e)
      if (phi[e] != 0) range.add(in(indices[e], c));
    if (range.holds(values[c])) continue;
    Scalar amplification = 0;
    for (std::int64_t e = begin; e < end; ++e) amplification += std::abs(phi[e]);
    limited += range.limit(values[c], kind, all[c], amplification);
  }
  return limited;
}

// The ranges of the components of a field.
template <class Scalar>
std::vector<DataRange<Scalar>> ranges_of(const FieldView<Scalar>& field, int threads) {
  constexpr std::size_t points_per_block = 65536;
  const auto components = static_cast<std::size_t>(field.components());
  const std::size_t blocks = (field.size() + points_per_block - 1) / points_per_block;
  std::vector<DataRange<Scalar>> of_blocks(blocks * components), ranges(components);
  recon::parallel_blocks(
      field.size(), points_per_block, threads, [&](std::size_t begin, std::size_t end) {
        auto* const mine = of_blocks.data() + begin / points_per_block * components;
        for (std::size_t c = 0; c < components; ++c) {
          DataRange<Scalar> range;
          for (std::size_t i = begin; i < end; ++i) {
            const Scalar value = field(i, static_cast<int>(c));
            if (!std::isfinite(value)) [[unlikely]]
              throw_not_finite(i, static_cast<int>(c), static_cast<double>(value));
            range.add(value);
          }
          mine[c] = range;
        }
      });
  for (std::size_t i = 0; i < of_blocks.size(); ++i)
    if (of_blocks[i].least <= of_blocks[i].greatest) {
      ranges[i % components].add(of_blocks[i].least);
      ranges[i % components].add(of_blocks[i].greatest);
    }
  return ranges;
}

// One product of an operator and a field: rows in blocks, each with as few branches as its numbers
// of blocks and components allow.
template <class Scalar>
class Product {
 public:
  Product(const SparsityPattern<Scalar>& pattern, const Scalar* values, int blocks,
          const FieldView<Scalar>& field, const FieldSpan<Scalar>& out, Scalar fill,
          const Apply& how, std::uint32_t* limited, int threads)
      : pattern_(pattern),
        values_(values),
        index_(pattern.neighbours.indices.data()),
        offsets_(pattern.neighbours.offsets.data()),
        blocks_(blocks),
        components_(field.components()),
        field_(field),
        out_(out),
        fill_(fill),
        limit_(how.limit),
        trusted_(how.data == Data::trusted && how.limit == Limit::none),
        limited_(limited) {
    if (limit_ == Limit::relaxed && how.bounds.empty())
      all_ = ranges_of(field, threads);
    else if (limit_ == Limit::relaxed)
      for (const DataBounds& bounds : how.bounds)
        all_.push_back({static_cast<Scalar>(bounds.least), static_cast<Scalar>(bounds.greatest)});
    else if (limit_ == Limit::range)  // needs no more than the data of each row
      all_.resize(static_cast<std::size_t>(components_));
  }

  void rows(std::size_t begin, std::size_t end) const {
    switch (blocks_) {
      case 1:
        rows_of<1>(begin, end);
        break;
      case 2:
        rows_of<2>(begin, end);
        break;
      case 3:
        rows_of<3>(begin, end);
        break;
      case 6:
        rows_of<6>(begin, end);
        break;
      default:
        rows_of_any(begin, end);
    }
    const auto& empty = pattern_.empty_rows;
    for (auto row = std::lower_bound(empty.begin(), empty.end(), begin);
         row != empty.end() && *row < end; ++row)
      for (int i = 0; i < components_ * blocks_; ++i) out_(pattern_.target(*row), i) = fill_;
  }

 private:
  static constexpr int any = 0;  // a number of blocks that is known at run time only

  template <int B>
  void rows_of(std::size_t begin, std::size_t end) const {
    if (!SideBySide<Scalar>::reads(field_))
      wide_rows<B, AnyLayout<Scalar>>(begin, end);
    else if (components_ == 1)
      narrow_rows<B, 1>(begin, end);
    else if (components_ == 2)
      narrow_rows<B, 2>(begin, end);
    else if (components_ == 3)
      narrow_rows<B, 3>(begin, end);
    else
      wide_rows<B, SideBySide<Scalar>>(begin, end);
  }

  // Of any number of blocks: one sum after the other.
  void rows_of_any(std::size_t begin, std::size_t end) const {
    std::vector<Scalar> sums(static_cast<std::size_t>(components_ * blocks_));
    for (std::size_t row = begin; row < end; ++row) {
      sums_of_any(values_, index_, offsets_[row], offsets_[row + 1], field_, sums.data());
      finish<any>(row, sums.data());
    }
  }

  void sums_of_any(const Scalar* values, const ParticleIndex* index, std::int64_t first,
                   std::int64_t last, const FieldView<Scalar>& field, Scalar* sums) const {
    for (int i = 0; i < components_ * blocks_; ++i)
      sums[i] = sum_of<Scalar>(last - first, [&](std::int64_t e) {
        return values[(first + e) * blocks_ + i % blocks_] * field(index[first + e], i / blocks_);
      });
  }

  template <int B, int C>
  void narrow_rows(std::size_t begin, std::size_t end) const {
    const SideBySide<Scalar> field(field_, 0);
    if (field.stride == C)
      narrow_rows<B, C>(begin, end, Packed<Scalar, C>{field.data});
    else
      narrow_rows<B, C>(begin, end, field);
  }

  template <int B, int C, class Field>
  void narrow_rows(std::size_t begin, std::size_t end, const Field& field) const {
    if (limit_ != Limit::none || out_.separate())
      return wide_rows<B, SideBySide<Scalar>>(begin, end);
    // The plain case: as little as possible beside the sums.
    std::byte* const out = static_cast<std::byte*>(out_.first(0));
    const std::ptrdiff_t next_target = out_.point_stride(), next = out_.component_stride();
    const std::uint32_t* const target_of =
        pattern_.target_of.empty() ? nullptr : pattern_.target_of.data();
    Scalar zero = 0;  // and NaN where any sum is not finite
    few_components<B, C>(begin, end, field, [&](std::size_t row, Scalar* sums) RECON_INLINE_LAMBDA {
      const std::size_t t = target_of ? target_of[row] : row;
      std::byte* const to = out + static_cast<std::ptrdiff_t>(t) * next_target;
      for (int i = 0; i < B * C; ++i) {
        *reinterpret_cast<Scalar*>(to + i * next) = sums[i];
        zero += sums[i] - sums[i];
      }
    });
    if (zero == 0 || trusted_) return;
    wide_rows<B, SideBySide<Scalar>>(begin, end);
  }

  template <int B, int C, class Field, class Finish>
  void few_components(std::size_t begin, std::size_t end, const Field& field,
                      const Finish& finish_row) const {
    // Copies: what is written might be what is read, as far as the compiler knows.
    const Scalar* const values = values_;
    const ParticleIndex* const index = index_;
    const std::int64_t* const offsets = offsets_;
    const Field from = field;
    std::int64_t first = offsets[begin];
    for (std::size_t row = begin; row < end; ++row) {
      const std::int64_t last = offsets[row + 1];
      Scalar sums[B * C];
      row_sums<B, C>(values, index, first, last, from, sums);
      finish_row(row, sums);
      first = last;
    }
  }

  template <int B, class Field>
  void wide_rows(std::size_t begin, std::size_t end) const {
    constexpr int few = 64;
    std::array<Scalar, few> on_stack;
    std::vector<Scalar> many(components_ * B > few ? static_cast<std::size_t>(components_ * B) : 0);
    Scalar* const sums = many.empty() ? on_stack.data() : many.data();
    for (std::size_t row = begin; row < end; ++row) {
      sums_of<B, Field>(values_, index_, offsets_[row], offsets_[row + 1], field_, sums);
      finish<B>(row, sums);
    }
  }

  // One row of any number of components.
  template <int B, class Field>
  void sums_of(const Scalar* values, const ParticleIndex* index, std::int64_t first,
               std::int64_t last, const FieldView<Scalar>& field, Scalar* sums) const {
    int c = 0;
    for (; c + 4 <= components_; c += 4)
      row_sums<B, 4>(values, index, first, last, Field{field, c}, sums + c * B);
    if (components_ - c == 3)
      row_sums<B, 3>(values, index, first, last, Field{field, c}, sums + c * B);
    if (components_ - c == 2)
      row_sums<B, 2>(values, index, first, last, Field{field, c}, sums + c * B);
    if (components_ - c == 1)
      row_sums<B, 1>(values, index, first, last, Field{field, c}, sums + c * B);
  }

  template <int B>
  void finish(std::size_t row, Scalar* sums) const {
    const int width = components_ * (B == any ? blocks_ : B);
    const std::size_t t = pattern_.target(row);
    if (!trusted_ && !all_finite(sums, width)) [[unlikely]]
      mend<B>(row, t, sums);
    if (limit_ != Limit::none)
      limited_[t] =
          limit_row(values_, index_, offsets_[row], offsets_[row + 1], field_, limit_, all_, sums);
    for (int i = 0; i < width; ++i) out_(t, i) = sums[i];
  }

  // Forms the sums of a row again, in the same order, with 0 for numbers that are not finite and not
  // needed: those of particles with the coefficient 0. One that is needed is named. What is not
  // finite then has left the range of numbers on its way.
  template <int B>
  [[gnu::noinline]] void mend(std::size_t row, std::size_t t, Scalar* sums) const {
    const int blocks = B == any ? blocks_ : B;
    const Scalar* const values = values_ + offsets_[row] * blocks;
    const std::int64_t count = offsets_[row + 1] - offsets_[row];
    std::vector<Scalar> in;
    std::vector<ParticleIndex> place;
    for (std::int64_t e = 0; e < count; ++e) {
      const ParticleIndex particle = index_[offsets_[row] + e];
      const bool needed = std::any_of(values + e * blocks, values + (e + 1) * blocks,
                                      [](Scalar value) { return value != 0; });
      for (int c = 0; c < components_; ++c) {
        const Scalar value = field_(particle, c);
        if (needed && !std::isfinite(value))
          throw_not_finite(particle, c, static_cast<double>(value));
        in.push_back(std::isfinite(value) ? value : Scalar(0));
      }
      place.push_back(static_cast<ParticleIndex>(e));
    }
    constexpr auto size = static_cast<std::ptrdiff_t>(sizeof(Scalar));
    const FieldView<Scalar> row_field(static_cast<std::size_t>(count), components_, in.data(),
                                      components_ * size, size);
    if constexpr (B == any)
      sums_of_any(values, place.data(), 0, count, row_field, sums);
    else
      sums_of<B, SideBySide<Scalar>>(values, place.data(), 0, count, row_field, sums);
    mend_overflow(sums, components_ * blocks, "target ", t, [&](int i) {
      return scaled_sum_of_products<Scalar>(
          count, [&](std::int64_t e) { return values[e * blocks + i % blocks]; },
          [&](std::int64_t e) { return row_field(static_cast<std::size_t>(e), i / blocks); });
    });
  }

  const SparsityPattern<Scalar>& pattern_;
  const Scalar* values_;
  const ParticleIndex* index_;
  const std::int64_t* offsets_;
  int blocks_, components_;
  const FieldView<Scalar>& field_;
  const FieldSpan<Scalar>& out_;
  Scalar fill_;
  Limit limit_;
  bool trusted_;
  std::uint32_t* limited_;
  std::vector<DataRange<Scalar>> all_;
};

}  // namespace recon::detail
