// A linear map from particle data to targets, a sparse row per target: values or derivatives.
//
//     out(t, c * blocks + b) = sum over the entries e of row t of  value(e, b) * in(index(e), c)
// with `blocks` numbers per entry: 1 for values, D for gradients (d/dx, d/dy, d/dz), D (D + 1) / 2
// for Hessians (xx, xy, xz, yy, yz, zz). A field of any number of components c goes through in one
// pass. The transpose takes target data back to particles, for example nodal forces:
//     out(p, c) = sum over the entries e with index p of
//                 sum_b value(e, b) * in(row(e), c * blocks + b) .
// <apply(u), f> = <u, apply_transpose(f)> to rounding, whatever the number of entries of a row or
// column (core/sums.hpp). Sums run in a fixed order: the same bits for any number of threads.
//
// Data near the largest number of the precision are no trouble by themselves: a sum that overflows
// on its way is formed again with scaled factors. A result that is too large itself throws
// InvalidArgument, naming target (or particle) and component. Results are never NaN or infinite,
// but for `fill`.
//
// A number that is multiplied by 0 everywhere is not needed, and may be anything, NaN too: that of a
// particle on the border of a support, where the weight is 0, or of a target whose row is all zero.
// The result is that with any finite number in its place. Trusted products do not look, and make
// NaN of it.
//
// An operator made of Sources (neighbourhood/sources.hpp) is of their positions at that time: after
// an update of the Sources its products, sums and rows throw InvalidArgument.
//
// Rows without support hold no entries; apply() writes `fill` there, the transpose ignores them.
// An operator is linear and never limited; limiting is a way to apply a reconstruction (limit.hpp).
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "recon/core/array.hpp"
#include "recon/neighbourhood/neighbour_list.hpp"
#include "recon/operators/limit.hpp"
#include "recon/points/view.hpp"

namespace recon {

namespace detail {
template <class Scalar>
class Cloud;
}

// Which particle each entry refers to, in the caller's numbers: shared by a value operator and its
// derivatives.
//
// Rows may stand in an order of their own, in which targets that follow each other are close in
// space: row i belongs to target target_of[i].
template <class Scalar>
struct SparsityPattern {
  std::size_t columns = 0;           // particles
  NeighbourList<Scalar> neighbours;  // of each row; a particle may appear twice (images)
  Array<std::uint32_t> target_of;    // empty: rows are targets
  Array<std::uint32_t> empty_rows;   // rows without support, ascending
  // The Sources that it was made of, and the count of their updates at that time.
  std::shared_ptr<const detail::Cloud<Scalar>> cloud;
  std::uint64_t version = 0;
  // What helps after an update of the Sources.
  const char* remedy = "call update() of the reconstruction, and ask it for its operators anew";

  std::size_t rows() const { return neighbours.targets(); }
  std::size_t target(std::size_t row) const { return target_of.empty() ? row : target_of[row]; }
  // The row of a target; the places of all are made on first use.
  std::size_t row(std::size_t target) const;

  // Throws InvalidArgument, with the remedy, where the Sources have been updated since.
  void require_current() const;

  // The entries of each particle in ascending order, made on first use. Column i belongs to
  // particle particle_of[i] (empty: i): the order of the Sources.
  struct Transposed {
    std::span<const std::uint32_t> particle_of;
    Array<std::int64_t> offsets;
    Array<std::int64_t> entries;
    Array<std::uint32_t> rows;
  };
  const Transposed& transposed() const;

  // Forgets what was made on first use, for another list in the same memory.
  void start_anew();

 private:
  mutable std::mutex mutex_;
  mutable std::atomic<bool> has_transposed_ = false, has_row_of_ = false;
  mutable Transposed transposed_;
  mutable Array<std::uint32_t> row_of_;
};

template <class Scalar>
class BasicReconstruction;

template <class Scalar>
class CsrOperator {
 public:
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  // The entries that one target's value is made of. Refers to the operator, which
  // must live as long.
  class Row {
   public:
    std::size_t size() const { return static_cast<std::size_t>(end_ - begin_); }
    ParticleIndex particle(std::size_t i) const {
      return op_->pattern_->neighbours.indices[begin_ + i];
    }
    Scalar value(std::size_t i, int block = 0) const {
      return op_->values_[(begin_ + i) * op_->blocks_ + block];
    }

   private:
    friend class CsrOperator;
    Row(const CsrOperator* op, std::int64_t begin, std::int64_t end)
        : op_(op), begin_(begin), end_(end) {}
    const CsrOperator* op_;
    std::int64_t begin_, end_;
  };

  CsrOperator() = default;
  CsrOperator(std::shared_ptr<const SparsityPattern<Scalar>> pattern, Array<Scalar> values,
              int blocks, Scalar fill, int threads);

  std::size_t rows() const { return pattern_->rows(); }      // targets
  std::size_t columns() const { return pattern_->columns; }  // particles
  int blocks() const { return blocks_; }                     // numbers per entry
  std::size_t entries() const { return pattern_->neighbours.indices.size(); }

  // The row of target t; one of a temporary operator, as in fit.gradient().row(t), would dangle:
  // give the operator a name. For all entries as a matrix see to_sparse() (operators/sparse.hpp).
  Row row(std::size_t target) const& {
    pattern_->require_current();
    const std::size_t row = pattern_->row(target);
    return {this, pattern_->neighbours.offsets[row], pattern_->neighbours.offsets[row + 1]};
  }
  Row row(std::size_t target) && = delete;
  std::vector<std::uint32_t> empty_rows() const;  // targets without support, ascending

  // All entries as they lie in memory: number b of entry e of the pattern's list at e * blocks() + b.
  // For other libraries' matrices; pattern().target_of says which target a row is.
  const SparsityPattern<Scalar>& pattern() const& { return *pattern_; }
  std::span<const Scalar> numbers() const& { return values_; }
  const SparsityPattern<Scalar>& pattern() && = delete;
  std::span<const Scalar> numbers() && = delete;

  Scalar fill() const { return fill_; }  // of rows without support
  int threads() const { return threads_; }

  // Operators on one pattern, as those of one reconstruction are, add up, entry by entry; the fill
  // value is that of the left one. Throws InvalidArgument for other patterns or numbers of blocks,
  // and where an entry of the result is not finite, naming target and particle; the operator stays
  // as it was then.
  CsrOperator& operator+=(const CsrOperator& other) { return add(other, Scalar(1)); }
  CsrOperator& operator-=(const CsrOperator& other) { return add(other, Scalar(-1)); }
  CsrOperator& operator*=(Scalar factor);
  friend CsrOperator operator+(CsrOperator a, const CsrOperator& b) { return std::move(a += b); }
  friend CsrOperator operator-(CsrOperator a, const CsrOperator& b) { return std::move(a -= b); }
  friend CsrOperator operator*(Scalar factor, CsrOperator a) { return std::move(a *= factor); }
  friend CsrOperator operator*(CsrOperator a, Scalar factor) { return std::move(a *= factor); }

  // A row per target. Throws InvalidArgument where the field has not one value per particle, and
  // where a value that a row needs is not finite, naming the particle and the component; those that
  // are in no row, or have the coefficient 0 in all of them, may be anything.
  Matrix apply(const FieldView<Scalar>& field) const;
  // The same into your own array, of rows() points and field.components() * blocks() components. It
  // must not overlap the input. With `trusted` as data nothing is checked but sizes (limit.hpp).
  // Where it throws, what has been written there is of no use.
  void apply(const FieldView<Scalar>& field, const FieldSpan<Scalar>& out,
             Data data = Data::checked) const;

  // A row per particle. The field has rows() values, with components a multiple of blocks(). One
  // that is not finite throws as above, naming target and component.
  Matrix apply_transpose(const FieldView<Scalar>& field) const;
  void apply_transpose(const FieldView<Scalar>& field, const FieldSpan<Scalar>& out) const;

 private:
  CsrOperator& add(const CsrOperator& other, Scalar factor);
  // Replaces each number i of values_ by changed(i); throws, and changes nothing, where one of these
  // is not finite.
  template <class Changed>
  void change_values(const Changed& changed);
  // Has any entry of the row a number other than 0 in this block?
  bool reads(std::size_t row, int block) const;

  // For a reconstruction, whose values may be limited: `limited` has a count per target.
  friend class BasicReconstruction<Scalar>;
  void apply(const FieldView<Scalar>& field, const FieldSpan<Scalar>& out, const Apply& how,
             std::uint32_t* limited) const;
  // Leaves an operator without rows; for another one in the same memory.
  Array<Scalar> give_up() {
    pattern_ = no_pattern();
    return std::move(values_);
  }

  static const std::shared_ptr<const SparsityPattern<Scalar>>& no_pattern();

  std::shared_ptr<const SparsityPattern<Scalar>> pattern_ = no_pattern();
  Array<Scalar> values_;  // entry-major: [e * blocks + b]
  int blocks_ = 1;
  Scalar fill_ = 0;
  int threads_ = 0;
};

extern template class CsrOperator<float>;
extern template class CsrOperator<double>;

}  // namespace recon
