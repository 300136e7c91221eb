#include "recon/operators/csr_operator.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>

#include "core/instantiate.hpp"
#include "neighbourhood/cloud.hpp"
#include "operators/product.hpp"
#include "recon/core/error.hpp"
#include "recon/core/parallel.hpp"
#include "recon/core/sums.hpp"
#include "recon/points/make_view.hpp"

namespace recon {
namespace {

using detail::require;

constexpr std::size_t rows_per_block = 1024;

// The field as one array in the order of `point_of` (empty: its own), point-major. Numbers that are
// not finite are refused where needed(place, component), and zeroed elsewhere; so are all of the
// places in `skip` (ascending).
template <class Scalar, class Needed>
Array<Scalar> gather(const FieldView<Scalar>& field, std::span<const std::uint32_t> point_of,
                     std::span<const std::uint32_t> skip, int threads, const Needed& needed) {
  const int components = field.components();
  Array<Scalar> values(field.size() * static_cast<std::size_t>(components));
  parallel_blocks(field.size(), 16 * rows_per_block, threads,
                  [&](std::size_t begin, std::size_t end) {
                    auto skipped = std::lower_bound(skip.begin(), skip.end(), begin);
                    Scalar* to = values.data() + begin * static_cast<std::size_t>(components);
                    for (std::size_t i = begin; i < end; ++i) {
                      const bool skips = skipped != skip.end() && *skipped == i;
                      skipped += skips;
                      const std::size_t point = point_of.empty() ? i : point_of[i];
                      for (int c = 0; c < components; ++c) {
                        Scalar value = skips ? Scalar(0) : field(point, c);
                        if (!std::isfinite(value)) [[unlikely]] {
                          if (needed(i, c))
                            detail::throw_not_finite(point, c, static_cast<double>(value));
                          value = 0;
                        }
                        *to++ = value;
                      }
                    }
                  });
  return values;
}

}  // namespace

template <class Scalar>
std::size_t SparsityPattern<Scalar>::row(std::size_t target) const {
  require(target < neighbours.targets(), "target", target,
          "must be smaller than the number of targets");
  if (target_of.empty()) return target;
  if (has_row_of_) return row_of_[target];
  const std::lock_guard lock(mutex_);
  if (!has_row_of_) {
    row_of_.resize(target_of.size());
    for (std::size_t i = 0; i < target_of.size(); ++i)
      row_of_[target_of[i]] = static_cast<std::uint32_t>(i);
    has_row_of_ = true;
  }
  return row_of_[target];
}

template <class Scalar>
void SparsityPattern<Scalar>::require_current() const {
  if (cloud && cloud->version() != version)
    detail::throw_invalid("positions", "those before an update of the Sources",
                          std::string("must be the present ones: ") + remedy);
}

template <class Scalar>
void SparsityPattern<Scalar>::start_anew() {
  has_transposed_ = has_row_of_ = false;
}

template <class Scalar>
const typename SparsityPattern<Scalar>::Transposed& SparsityPattern<Scalar>::transposed() const {
  if (has_transposed_) return transposed_;
  const std::lock_guard lock(mutex_);
  if (has_transposed_) return transposed_;
  const Array<ParticleIndex>& indices = neighbours.indices;
  std::span<const std::uint32_t> place_of;
  Transposed& t = transposed_;
  if (cloud) {
    place_of = cloud->place_of();
    t.particle_of = cloud->caller_of();
  }
  const auto column = [&](std::int64_t e) {
    return place_of.empty() ? indices[e] : place_of[indices[e]];
  };
  const auto count = static_cast<std::int64_t>(indices.size());
  t.offsets.assign(columns + 1, std::int64_t{0});
  for (std::int64_t e = 0; e < count; ++e) ++t.offsets[column(e) + 1];
  for (std::size_t p = 0; p < columns; ++p) t.offsets[p + 1] += t.offsets[p];
  t.entries.resize(indices.size());
  t.rows.resize(indices.size());
  // Each offset moves on to the end of its column, which is where the next begins.
  for (std::size_t row = 0; row < rows(); ++row)
    for (std::int64_t e = neighbours.offsets[row]; e < neighbours.offsets[row + 1]; ++e) {
      const std::int64_t at = t.offsets[column(e)]++;
      t.entries[at] = e;
      t.rows[at] = static_cast<std::uint32_t>(row);
    }
  for (std::size_t p = columns; p > 0; --p) t.offsets[p] = t.offsets[p - 1];
  t.offsets[0] = 0;
  has_transposed_ = true;
  return transposed_;
}

template <class Scalar>
const std::shared_ptr<const SparsityPattern<Scalar>>& CsrOperator<Scalar>::no_pattern() {
  static const std::shared_ptr<const SparsityPattern<Scalar>> empty =
      std::make_shared<SparsityPattern<Scalar>>();
  return empty;
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
CsrOperator<Scalar>& CsrOperator<Scalar>::add(const CsrOperator& other, Scalar factor) {
  require(pattern_ == other.pattern_, "pattern of the operator", "another",
          "must be the same: operators of one reconstruction add up");
  require(blocks_ == other.blocks_, "blocks of the operator", other.blocks_,
          "must be as many as those of the other");
  change_values([&](std::size_t i) { return values_[i] + factor * other.values_[i]; });
  return *this;
}

template <class Scalar>
CsrOperator<Scalar>& CsrOperator<Scalar>::operator*=(Scalar factor) {
  require(std::isfinite(factor), "factor of the operator", factor, "must be finite");
  change_values([&](std::size_t i) { return values_[i] * factor; });
  return *this;
}

template <class Scalar>
template <class Changed>
void CsrOperator<Scalar>::change_values(const Changed& changed) {
  pattern_->require_current();
  constexpr std::size_t block = 16 * rows_per_block;
  parallel_blocks(values_.size(), block, threads_, [&](std::size_t begin, std::size_t end) {
    Scalar zero = 0;  // and NaN where any number is not finite
    for (std::size_t i = begin; i < end; ++i) {
      const Scalar value = changed(i);
      zero += value - value;
    }
    for (std::size_t i = begin; zero != 0 && i < end; ++i)
      if (const Scalar value = changed(i); !std::isfinite(value)) {
        const auto blocks = static_cast<std::size_t>(blocks_);
        const auto& offsets = pattern_->neighbours.offsets;
        const auto next =
            std::upper_bound(offsets.begin(), offsets.end(), static_cast<std::int64_t>(i / blocks));
        const auto row = static_cast<std::size_t>(next - offsets.begin()) - 1;
        detail::throw_invalid("coefficient of particle " +
                                  std::to_string(pattern_->neighbours.indices[i / blocks]) +
                                  " at target " + std::to_string(pattern_->target(row)) +
                                  (blocks_ > 1 ? " in block " + std::to_string(i % blocks) : ""),
                              value, "overflows: the operators or their factors are too large");
      }
  });
  parallel_blocks(values_.size(), block, threads_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) values_[i] = changed(i);
  });
}

template <class Scalar>
bool CsrOperator<Scalar>::reads(std::size_t row, int block) const {
  const auto& offsets = pattern_->neighbours.offsets;
  for (std::int64_t e = offsets[row]; e < offsets[row + 1]; ++e)
    if (values_[e * blocks_ + block] != 0) return true;
  return false;
}

template <class Scalar>
std::vector<std::uint32_t> CsrOperator<Scalar>::empty_rows() const {
  pattern_->require_current();
  std::vector<std::uint32_t> targets;
  for (const std::uint32_t row : pattern_->empty_rows)
    targets.push_back(static_cast<std::uint32_t>(pattern_->target(row)));
  std::sort(targets.begin(), targets.end());
  return targets;
}

template <class Scalar>
void CsrOperator<Scalar>::apply(const FieldView<Scalar>& field, const FieldSpan<Scalar>& out,
                                Data data) const {
  apply(field, out, Apply{.data = data}, nullptr);
}

template <class Scalar>
void CsrOperator<Scalar>::apply(const FieldView<Scalar>& field, const FieldSpan<Scalar>& out,
                                const Apply& how, std::uint32_t* limited) const {
  pattern_->require_current();  // first: the number of particles may have changed
  detail::require_limit(how.limit);
  require(how.data == Data::checked || how.data == Data::trusted, "data",
          static_cast<int>(how.data), "must be an enumerator of recon::Data");
  require(field.size() == columns(), "size of the field", field.size(),
          "must be the number of particles");
  require(how.bounds.empty() || how.bounds.size() == static_cast<std::size_t>(field.components()),
          "number of bounds", how.bounds.size(), "must be that of the components of the field");
  for (const DataBounds& bounds : how.bounds)
    require(bounds.least <= bounds.greatest, "least value of the bounds", bounds.least,
            "must be at most the greatest");
  require(out.size() == rows(), "size of the output", out.size(), "must be the number of targets");
  require(out.components() == field.components() * blocks_, "components of the output",
          out.components(), "must be those of the field times the operator's blocks");
  const detail::Product<Scalar> product(*pattern_, values_.data(), blocks_, field, out, fill_, how,
                                        limited, threads_);
  parallel_blocks(rows(), rows_per_block, threads_,
                  [&](std::size_t begin, std::size_t end) { product.rows(begin, end); });
}

template <class Scalar>
void CsrOperator<Scalar>::apply_transpose(const FieldView<Scalar>& field,
                                          const FieldSpan<Scalar>& out) const {
  const SparsityPattern<Scalar>& pattern = *pattern_;
  pattern.require_current();
  require(field.size() == rows(), "size of the field", field.size(),
          "must be the number of targets");
  require(field.components() % blocks_ == 0, "components of the field", field.components(),
          "must be a multiple of the operator's blocks");
  const int components = field.components() / blocks_;
  require(out.size() == columns(), "size of the output", out.size(),
          "must be the number of particles");
  require(out.components() == components, "components of the output", out.components(),
          "must be those of the field divided by the operator's blocks");
  const Array<Scalar> in =
      gather<Scalar>(field, pattern.target_of, pattern.empty_rows, threads_,
                     [&](std::size_t row, int c) { return reads(row, c % blocks_); });
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
      const std::size_t p =
          columns_of.particle_of.empty() ? column : columns_of.particle_of[column];
      if (!detail::all_finite(sums.data(), components)) [[unlikely]]
        detail::mend_overflow(sums.data(), components, "particle ", p, [&](int c) {
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

RECON_FLOAT(template struct SparsityPattern<float>;)
template struct SparsityPattern<double>;
RECON_FLOAT(template class CsrOperator<float>;)
template class CsrOperator<double>;

}  // namespace recon
