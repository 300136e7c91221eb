// What the author of a particle code writes by hand, and what recon is measured against.
//
//   search     nanoflann's k-d tree over an own array of points, one call per target
//   construct  the basis in offsets scaled by the support radius, cubic B-spline weight, moment
//              matrix by rank-1 updates, fixed-size LDLT of Eigen, coefficients stored
//   apply      a dot product per target
//
// Parallel loops of OpenMP; support radius 1.5 times the k-th distance, as recon's Nearest has it,
// so that the answers agree. No rank handling: a singular neighbourhood gives what LDLT makes of
// it. Compiled with -O3 -march=native into a shared library of its own, so that nothing of it is
// linked into recon and nothing of recon is compiled for the native machine.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace hand_written {

template <class Scalar, int D>
using Points = std::vector<std::array<Scalar, D>>;

// An array that is not zeroed first.
template <class T>
using Array = std::unique_ptr<T[]>;

// k neighbours per target by ascending distance: entry j of target t is at t * k + j.
template <class Scalar>
struct Neighbours {
  int k = 0;
  Array<std::uint32_t> index;
  Array<Scalar> distance2;
};

template <class Scalar, int D>
Neighbours<Scalar> search(const Points<Scalar, D>& sources, const Points<Scalar, D>& targets, int k,
                          int threads);

// The coefficients phi of sum_j phi[t * k + j] * u[index[t * k + j]].
template <class Scalar, int D, int Degree>
Array<Scalar> construct(const Points<Scalar, D>& sources, const Points<Scalar, D>& targets,
                        const Neighbours<Scalar>& neighbours, int threads);

template <class Scalar>
void apply(const Neighbours<Scalar>& neighbours, const Scalar* coefficients, const Scalar* u,
           std::size_t targets, Scalar* out, int threads);

const char* eigen_version();
int nanoflann_version();  // 0x142 is 1.4.2

}  // namespace hand_written
