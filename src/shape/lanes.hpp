// Shape functions of several targets side by side, one in each lane, for each instruction set.
//
// Only regular targets are treated here; the others are left to the kernel for single targets
// (kernel.hpp). Plain arrays in and out: the files compiled for an instruction set share no types
// with the rest of the library whose code they might instantiate (core/dispatch.hpp).
#pragma once

#include <array>
#include <cstdint>

#include "core/dispatch.hpp"
#include "recon/local_solve/fill_report.hpp"
#include "recon/shape/shape_kernel.hpp"

namespace recon::detail {

struct LaneReport {
  FitNumbers numbers;  // neighbours: those with a weight
  bool done = false;   // else the target needs a closer look, and its rows are not written
};

template <class Scalar>
struct LaneTask {
  const Scalar* particles = nullptr;      // D coordinates of each
  const Scalar* targets = nullptr;        // from `begin` on, D coordinates of each
  const std::int64_t* offsets = nullptr;  // the neighbour list
  const ParticleIndex* indices = nullptr;
  const ImageShift* shifts = nullptr;  // null: none
  const Scalar* support = nullptr;
  const Scalar* pair_support = nullptr;  // null: none
  // Where supports are ellipsoids, local_frames.hpp: x_p - x of the entries, from the first of
  // `begin` on, D numbers each, `targets` then only their sizes; and q and q dq / dxi of the
  // entries whose supports belong to the pair. Null: none.
  const Scalar* local_offsets = nullptr;
  const Scalar* pair_distances = nullptr;
  const Scalar* pair_slopes = nullptr;
  std::array<Scalar, max_dimension> period{};
  Scalar support_factor = 0;                 // as in NeighbourList
  const Scalar* particle_weights = nullptr;  // as in ShapeProblem
  std::array<Scalar, max_dimension> axis_scale{1, 1, 1};
  typename WeightFunction::Function<Scalar> weigh = nullptr;
  const void* weight = nullptr;
  WeightForm form = WeightForm::radial;
  Solver solver = Solver::gram_schmidt;
  std::size_t begin = 0, end = 0;  // targets
  ShapeRows<Scalar> rows{};        // reports are not written
  LaneReport* reports = nullptr;   // end - begin of them
};

// A worker takes one task after another with memory that it keeps, for one thread at a time. Plain
// functions: a class with virtual functions would be shared. All null where there are no lanes.
template <class Scalar>
struct LaneFunctions {
  void* (*make)(const FitTolerances& tolerances) = nullptr;
  void (*run)(void* worker, const LaneTask<Scalar>& task) = nullptr;
  void (*destroy)(void* worker) = nullptr;
};

}  // namespace recon::detail

namespace recon {

// The function for a degree and solver; null for solvers that work on single targets only.
RECON_FOR_EACH_SET(template <class Scalar, int D> detail::LaneFunctions<Scalar> lane_functions(
    int degree, Solver solver))

}  // namespace recon
