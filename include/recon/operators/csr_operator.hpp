// A linear map from particle data to targets, one sparse row per target: values, gradients,
// Hessians.
//
//     out(t, c * blocks + b) = sum over the entries e of row t of  value(e, b) * in(index(e), c)
// with `blocks` numbers per entry: 1 for values, D for gradients (d/dx, d/dy, d/dz), D (D + 1) / 2
// for Hessians (xx, xy, xz, yy, yz, zz). A field of any number of components c goes through in one
// pass. The transpose takes target data back to particles, for example nodal forces:
//     out(p, c) = sum over the entries e with index p of  sum_b value(e, b) * in(row(e), c * blocks
//     + b) .
// <apply(u), f> = <u, apply_transpose(f)> to rounding. Sums run in a fixed order: the same bits for
// any number of threads.
//
// Rows without support hold no entries; apply() writes `fill` there, the transpose ignores them.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "recon/neighbourhood/neighbour_list.hpp"
#include "recon/points/view.hpp"

namespace recon {

// Which particle each entry refers to, shared by a value operator and its derivatives.
template <class Scalar>
struct SparsityPattern {
  std::size_t columns = 0;           // particles
  NeighbourList<Scalar> neighbours;  // an entry per neighbour; a particle may appear twice (images)
  std::vector<std::uint32_t> empty_rows;  // rows without support, ascending

  std::size_t rows() const { return neighbours.targets(); }

  // The entries of each column in ascending order, made on first use.
  struct Transposed {
    std::vector<std::int64_t> offsets;
    std::vector<std::int64_t> entries;
    std::vector<std::uint32_t> rows;
  };
  const Transposed& transposed() const;

 private:
  mutable std::once_flag once_;
  mutable Transposed transposed_;
};

template <class Scalar>
class CsrOperator {
 public:
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  CsrOperator() = default;
  CsrOperator(std::shared_ptr<const SparsityPattern<Scalar>> pattern, std::vector<Scalar> values,
              int blocks, Scalar fill, int threads);

  std::size_t rows() const { return pattern_->rows(); }      // targets
  std::size_t columns() const { return pattern_->columns; }  // particles
  int blocks() const { return blocks_; }                     // numbers per entry
  std::size_t entries() const { return pattern_->neighbours.indices.size(); }
  std::span<const std::int64_t> offsets() const& { return pattern_->neighbours.offsets; }
  std::span<const ParticleIndex> indices() const& { return pattern_->neighbours.indices; }
  std::span<const Scalar> values() const& { return values_; }  // entry-major: [e * blocks + b]
  std::span<const std::uint32_t> empty_rows() const& { return pattern_->empty_rows; }

  // A span of a temporary operator, as in fit.gradient().values(), would dangle: give the operator
  // a name.
  void offsets() && = delete;
  void indices() && = delete;
  void values() && = delete;
  void empty_rows() && = delete;

  // A row per target; throws InvalidArgument where the field has not one value per particle, or has
  // one that is not finite (naming the particle and the component).
  Matrix apply(const FieldView<Scalar>& field) const;
  // The same into your own array, of rows() points and field.components() * blocks() components. It
  // must not overlap the input.
  void apply(const FieldView<Scalar>& field, const FieldSpan<Scalar>& out) const;

  // A row per particle. The field has rows() values, with components a multiple of blocks().
  Matrix apply_transpose(const FieldView<Scalar>& field) const;
  void apply_transpose(const FieldView<Scalar>& field, const FieldSpan<Scalar>& out) const;

 private:
  std::shared_ptr<const SparsityPattern<Scalar>> pattern_ =
      std::make_shared<SparsityPattern<Scalar>>();
  std::vector<Scalar> values_;
  int blocks_ = 1;
  Scalar fill_ = 0;
  int threads_ = 0;
};

extern template class CsrOperator<float>;
extern template class CsrOperator<double>;

}  // namespace recon
