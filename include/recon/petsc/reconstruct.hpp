// reconstruct(particles, targets, options) where both are spread over the ranks in any way.
//
// ```cpp
//   const recon::petsc::Reconstruction fit(PETSC_COMM_WORLD, points, targets,
//                                          {.degree = 2, .neighbours = recon::Radius{2 * h}});
//   Eigen::MatrixXd v = fit.values().apply(velocity);               // a row per target of this rank
//   Eigen::MatrixXd f = fit.values().apply_transpose(target_force); // a row per particle of this rank
// ```
//
// Each rank gives its particles and its targets; every target sees the particles of all ranks. A
// rank gets those of other ranks that lie in the box of its targets, enlarged by their supports:
// its halo. Fits, operators and reports are then those of reconstruct() (operators/reconstruct.hpp)
// with the particles of all ranks, entry by entry to rounding, for any solver, degree, weight and
// periodic domain. Particles have global ids: those of rank 0 are 0, 1, 2, ..., then come those of
// rank 1.
//
// The transpose returns each sum to the rank of the particle:
//     sum over all targets of apply(u) f = sum over all particles of u apply_transpose(f) .
//
// Options::neighbours may be Radius, Radii and NearestWithin, whose halo is known beforehand, and
// Nearest: there the halo is made from a guess and doubled until no target has a support that is
// larger than it, which proves that no particle beyond could be one of the k nearest. What needs
// more than a halo is refused on all ranks, naming the option: PairRadii, Ellipsoids and
// PairEllipsoids, Unsupported::nearest, max_distance and `visible`. Among particles at the same
// distance Nearest may choose others than the serial search does.
//
// Cost: two 8-byte numbers per axis from every rank to every rank, then messages between ranks
// whose boxes overlap. Targets of a rank should lie together: one box is around all of them. Each
// apply() is one round of messages (a broadcast of PetscSF) of 8 bytes for each halo particle and
// component, each apply_transpose() one round back (a reduction).
//
// Everything but rows(), reports and counts is collective.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "recon/operators/reconstruct.hpp"
#include "recon/petsc/communicator.hpp"

namespace recon::petsc {

class Halo;

// A linear map from the particles of all ranks to the targets of this one: CsrOperator with
// messages.
class Operator {
 public:
  using Matrix = CsrOperator<double>::Matrix;

  // One entry of a row: the global id of the particle, and a number for each block.
  struct Entry {
    std::int64_t particle;
    std::vector<double> values;
  };

  // A row per target of this rank; the field is that of the particles of this rank. Collective.
  // Throws InvalidArgument for sizes, and for data that are not finite on the rank that has them
  // (naming the particle; even where no row needs them), and as CsrOperator::apply does.
  Matrix apply(const FieldView<double>& field) const;
  // A row per particle of this rank; the field is that of the targets of this rank. Collective.
  Matrix apply_transpose(const FieldView<double>& field) const;

  std::size_t rows() const { return local_.rows(); }  // targets of this rank
  int blocks() const { return local_.blocks(); }
  // The entries of target t of this rank, by ascending ids; periodic images of one particle are
  // entries of their own.
  std::vector<Entry> row(std::size_t target) const;

 private:
  friend class Reconstruction;
  Operator(CsrOperator<double> local, std::shared_ptr<const Halo> halo)
      : local_(std::move(local)), halo_(std::move(halo)) {}
  CsrOperator<double> local_;
  std::shared_ptr<const Halo> halo_;
};

class Reconstruction {
 public:
  // Collective. Throws InvalidArgument as reconstruct() does, for what is refused above, and where
  // dimensions, degree or domain differ between ranks.
  Reconstruction(MPI_Comm comm, const PointsView<double>& points, const PointsView<double>& targets,
                 const Options& options = {});

  // Operators of this fit; see BasicReconstruction. Not collective, but for failures: where one
  // rank runs out of memory, the others do not know.
  Operator values() const { return {local_.values(), halo_}; }
  Operator gradient(Derivative kind = Derivative::exact) const {
    return {local_.gradient(kind), halo_};
  }
  Operator hessian() const { return {local_.hessian(), halo_}; }

  // Values, limited as in BasicReconstruction::apply(): a row per target of this rank. Collective;
  // the limit is the same on all ranks. Apply::count is of the targets of this rank, and bounds are
  // found here, from the data of all ranks. Throws InvalidArgument as Operator::apply() does.
  Operator::Matrix apply(const FieldView<double>& field, const Apply& how = {}) const;

  // What became of each target of this rank.
  const FitReports& report() const { return local_.report(); }
  // The number of particles of other ranks that this rank has got, and how many rounds of halos
  // that took: 1 unless the rule is Nearest.
  std::size_t halo_size() const;
  int halo_rounds() const;

 private:
  std::shared_ptr<const Halo> halo_;
  recon::Reconstruction local_;
};

}  // namespace recon::petsc
