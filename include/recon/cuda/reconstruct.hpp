// Reconstruction at targets in the memory of a GPU: values, derivatives, transposes.
//
// ```cpp
//   recon::cuda::Sources<3> sources({x_p, particle_count}, {}, stream);
//   recon::cuda::Reconstruction<3> fit(sources, {x_t, target_count}, {.degree = 2});
//   fit.apply({u_p, particle_count}, {u_t, target_count});            // sum_p phi_p u_p
//   fit.apply_transpose({f_t, target_count}, {f_p, particle_count});  // sum_t phi_p(x_t) f_t
//   auto gradient = fit.gradient();
//   fit.apply(gradient, {u_p, particle_count}, {grad_u, target_count, 3});
//   sources.update({x_p, particle_count});  // they have moved
//   fit.update({x_t, target_count});        // in the same memory
//   fit.gradient(gradient);
//   fit.check();  // waits, and throws if a coordinate was not finite
// ```
//
// What is computed is what recon::reconstruct() computes (operators/reconstruct.hpp), by the same
// templates: weighted least squares of graded degree, by the moment matrix or by Gram-Schmidt, and
// a FitReport of every target. Targets whose moment matrix is not safe are gathered and fitted by
// Gram-Schmidt on the GPU. Neighbours are the same particles, those at equal distance included, and
// values agree to rounding. A report can differ where a number lies within rounding of the
// threshold that decides. All results have the same bits in every run.
//
// Options are those of reconstruct(), as far as they are here; what is not is refused, naming the
// option. There are: degree 0 to 2, the weights by name, radial supports, Radius and Nearest,
// moment_matrix and gram_schmidt, tolerances, fill_value. `threads` and `instruction_set` mean
// nothing here. Domain and stretch are those of the Sources.
//
// All work goes to the stream of the Sources, and nobody waits for it, with these exceptions: the
// constructor waits for the number of neighbours where the rule is a Radius; check() and entries()
// wait, as they say. update() takes memory only for more targets than there ever were. With a
// Radius there is memory for a quarter more neighbours than there were at first, and for rows half
// as long again as the longest. An update that finds more leaves all targets without support (their
// values are fill_value) and says so in check(); reserve() is the remedy.
//
// Memory in 3-D (double): 16 bytes for each neighbour of each target, 150 for each target, and up
// to 128 MB for those that are fitted by Gram-Schmidt; a thread has memory of its own for 32
// neighbours, or 96 where rows are longer, for which the driver sets aside some GB (up to 3, or 11,
// on a GPU with 132 processors). Still longer rows are fitted as the unsafe ones are: right, but
// slowly.
#pragma once

#include <cstdint>
#include <memory>

#include "recon/cuda/sources.hpp"
#include "recon/local_solve/report.hpp"
#include "recon/shape/options.hpp"

namespace recon::cuda {

// A sparse row for each target: entries offsets[r] <= e < offsets[r + 1] of row r are the
// neighbours of the caller's target target_of[r], and columns[e] is the caller's number of the
// particle. In a periodic domain shifts[e] says which image is meant, else it is null: the shifts
// along the axes, each plus 128, are its bytes from the third lowest (x) to the lowest (z). All on
// the GPU, valid until the next update.
struct CsrRows {
  std::size_t rows = 0;
  const std::int64_t* offsets = nullptr;
  const std::uint32_t *columns = nullptr, *shifts = nullptr, *target_of = nullptr;
};

// Numbers for the entries of CsrRows: `blocks` side by side for each entry, 1 for values and
// Laplacians, D for gradients, D (D + 1) / 2 for Hessians (xx, xy, xz, yy, yz, zz). It goes with
// the Reconstruction that made it.
template <int D, class T = double>
class Operator {
 public:
  struct Numbers;

  Operator();
  Operator(Operator&&) noexcept;
  Operator& operator=(Operator&&) noexcept;
  ~Operator();

  int blocks() const;
  const T* values() const;  // on the GPU
  Numbers& numbers() const { return *numbers_; }

 private:
  std::unique_ptr<Numbers> numbers_;
};

template <int D, class T = double>
class Reconstruction {
 public:
  // Throws InvalidArgument for options that are bad or not to be had on a GPU, and for 2^32 - 1
  // neighbours of all targets or more; Error where there is no memory.
  Reconstruction(const Sources<D, T>& sources, const Points<D, T>& targets,
                 const Options& options = {});
  Reconstruction(Reconstruction&&) noexcept;
  Reconstruction& operator=(Reconstruction&&) noexcept;
  ~Reconstruction();

  // For these targets, more or fewer, and the present positions of the Sources. Operators that were
  // made before are stale: they are refused until they are made again.
  void update(const Points<D, T>& targets);
  // Memory for so many neighbours of all targets together and of a single one, from the next update
  // on.
  void reserve(std::int64_t neighbours, std::int64_t of_one_target);

  // Waits, and throws InvalidArgument for particles and targets that are not finite (naming point
  // and axis), for targets whose support cannot be represented or needs shifts beyond 127 periods,
  // and for more neighbours than there is memory for; Error where the work itself failed.
  void check() const;

  std::size_t targets() const;
  // On the GPU, valid until the next update: what became of each target, by the caller's numbers;
  // the support radius of each row, a length (in stretched coordinates); the rows.
  const FitReport* reports() const;
  const T* support() const;
  CsrRows rows() const;
  const T* values() const;  // phi_p of each entry
  // Waits for the number of entries of all rows.
  std::int64_t entries() const;

  // Operators of derivatives, as those of reconstruct() (1/length; 1/length^2); the second kind
  // writes into the memory of one that was made before.
  Operator<D, T> gradient(Derivative kind = Derivative::exact);
  Operator<D, T> hessian();
  Operator<D, T> laplacian();
  void gradient(Operator<D, T>& into, Derivative kind = Derivative::exact);
  void hessian(Operator<D, T>& into);
  void laplacian(Operator<D, T>& into);

  // out(t, c) = sum_p phi_p(x_t) in(p, c), and for operators out(t, c * blocks + b); fill_value
  // where a target has no support. Throws InvalidArgument for sizes that do not fit.
  void apply(const Field<const T>& in, const Field<T>& out);
  void apply(const Operator<D, T>& values, const Field<const T>& in, const Field<T>& out);
  // out(p, c) = sum_t phi_p(x_t) in(t, c), and for operators the sum over b of in(t, c * blocks +
  // b): the transpose, each sum in a fixed order. The first call takes 16 bytes of memory for each
  // entry; after an update it sorts the entries by columns.
  void apply_transpose(const Field<const T>& in, const Field<T>& out);
  void apply_transpose(const Operator<D, T>& values, const Field<const T>& in, const Field<T>& out);

 private:
  struct OnDevice;
  std::unique_ptr<OnDevice> on_device_;
};

}  // namespace recon::cuda
