// The neighbours of all targets at once: particles, their periodic images, support radii.
//
// A rule says who is a neighbour of a target at x, and what its support radius rho (a length) is:
//   Radius{r}            |x_p - x| <= r;                              rho = r
//   Radii{r}             |x_p - x| <= r[target];                      rho = r[target]
//   Nearest{k, factor}   the k nearest particles;                     rho = factor * k-th distance
//   NearestWithin{k, r}  the k nearest of those with |x_p - x| <= r;  rho = r
//   PairRadii{h}         |x_p - x| <= h_p, a radius of each particle;   rho = the largest h_p
//   Ellipsoids{A}        |A_t^-1 (x_p - x)| <= 1, a tensor of each target; rho = largest half axis
//   PairEllipsoids{A}    |A_p^-1 (x_p - x)| <= 1, a tensor of each particle; rho = largest of all
// PairRadii also takes the mean of h_p and of a radius h_t of the target, or the larger one, as in
// smoothed particle hydrodynamics (Monaghan 2005, sec. 2.7); its lists hold the radius of each
// pair. What a fit judges against the support (FitTolerances::gradient_extent) it judges against
// the largest h_p that reaches the target: one radius a thousand times the others makes slopes
// there unresolved, which FitReport::gradient_rank says.
// Ellipsoids have any orientation: support_tensor.hpp says what A is. PairEllipsoids also takes the
// mean (A_p + A_t) / 2; of two ellipsoids neither is the larger. Its lists hold the tensor of each
// pair, 8 D (D + 1) / 2 bytes in double, and for each target the mean of them, enlarged to rho: in
// its coordinates the fit is made and judged.
// With SupportShape::cube, for tensor-product weights, the support is the cube |x_p - x| <= rho on
// every axis: Radius and Radii take all in the cube, NearestWithin the k nearest (Euclidean) in the
// cube, and Nearest the k nearest with rho = factor * the largest distance along an axis. That of
// Ellipsoids is the parallelepiped of the tensor; PairEllipsoids has balls only.
//
// Order: Radius, Radii, PairRadii and the ellipsoids list by ascending (index, shift); the nearest
// rules by ascending (distance, index, shift). The result depends neither on the search method nor
// on the instruction set nor on the number of threads, to the bit.
//
// Periodic domains: every image of a particle counts, so a particle can be listed several times
// with different shifts, and supports may exceed the period. The image of p with shift s is at
// x_p + s * period; its distance is that of x - s * period to x_p. Particles and targets must lie
// in the domain (PointCloud wraps them). A shift beyond +-127 throws InvalidArgument.
//
// Degenerate cases. Fewer than k particles: all of them (in a periodic domain further images
// instead). All neighbours coincide with the target: rho is the distance to the nearest particle
// that does not (images not counted), else the mean spacing (volume / particles)^(1 / axes) over
// the axes along which the particles or the periods extend, else 1. No neighbours at all: count 0;
// rho is r, or for Nearest the mean spacing, else 1; for PairRadii h_t, or the largest h_p of all;
// for PairEllipsoids A_t, or a ball of the largest half axis of all.
//
// Cost: building the search, then one query per target (per image that can reach the particles).
// The fastest are evenly spread particles (their density may vary by a factor of 100 or so), in any
// order.
#pragma once

#include <concepts>
#include <cstddef>
#include <functional>
#include <span>
#include <variant>

#include "recon/core/instruction_set.hpp"
#include "recon/core/progress.hpp"
#include "recon/neighbourhood/neighbour_list.hpp"
#include "recon/neighbourhood/support_tensor.hpp"
#include "recon/points/domain.hpp"
#include "recon/points/point_cloud.hpp"

namespace recon {

struct Radius {
  double radius;  // positive; length
};
struct Radii {
  std::span<const double> radii;  // one per target, positive; length
};
// Of any integer type; a negative number of neighbours is refused when it is used.
struct Nearest {
  std::size_t k;  // at least 1
  double factor;  // larger than 1, so that no neighbour lies on the border of the support

  template <std::integral Count>
  constexpr Nearest(Count count, double support_factor = 1.5)
      : k(static_cast<std::size_t>(count)), factor(support_factor) {}
};
struct NearestWithin {
  std::size_t k;  // at least 1
  double radius;  // positive; length

  template <std::integral Count>
  constexpr NearestWithin(Count count, double support_radius)
      : k(static_cast<std::size_t>(count)), radius(support_radius) {}
};
// The support radius of a pair: h_p of the particle, the mean of h_p and h_t, or the larger one.
enum class PairSupport { particle, mean, larger };
struct PairRadii {
  std::span<const double> particles;  // h_p, one per particle, positive; length
  std::span<const double> targets{};  // h_t, one per target, positive; none for `particle`
  PairSupport support = PairSupport::particle;
};
struct Ellipsoids {
  FieldView<double> tensors;  // A_t, one per target; lengths
};
struct PairEllipsoids {
  FieldView<double> particles;                  // A_p, one per particle; lengths
  FieldView<double> targets{};                  // A_t, one per target; none for `particle`
  PairSupport support = PairSupport::particle;  // or mean
};
using NeighbourRule =
    std::variant<Radius, Radii, Nearest, NearestWithin, PairRadii, Ellipsoids, PairEllipsoids>;

enum class SupportShape { ball, cube };

// automatic: brute force for few particles, else the cell grid, in batches of targets; the k-d tree
// for uneven particles, and the k nearest with visibility or in a cube. r_tree may be left out.
enum class SearchMethod { automatic, kd_tree, r_tree, cell_grid, brute_force };

// May this particle be a neighbour of this target? Called concurrently, possibly more than once for
// the same pair. A particle that fails takes no place among the k nearest: the search goes on.
using Visibility = std::function<bool(std::size_t target, std::size_t particle)>;

struct NeighbourOptions {
  SupportShape shape = SupportShape::ball;
  SearchMethod search = SearchMethod::automatic;
  Visibility visible{};                                        // empty: every particle is
  int threads = 0;                                             // 0: default_threads()
  InstructionSet instruction_set = InstructionSet::automatic;  // of the search by cells
  Progress progress{};                                         // empty: nobody is told
};

// Throws InvalidArgument for rules with values outside their range, radii and tensors that are not
// one per target or particle, tensors that are no support tensors, clouds of different dimension or
// outside the periodic domain, and supports that need shifts beyond +-127. find_neighbours_with.hpp
// does the same with a search of your own.
template <class Scalar>
NeighbourList<Scalar> find_neighbours(const PointCloud<Scalar>& particles,
                                      const PointCloud<Scalar>& targets, const NeighbourRule& rule,
                                      const PeriodicDomain<Scalar>& domain = {},
                                      const NeighbourOptions& options = {});

extern template NeighbourList<float> find_neighbours(const PointCloud<float>&,
                                                     const PointCloud<float>&, const NeighbourRule&,
                                                     const PeriodicDomain<float>&,
                                                     const NeighbourOptions&);
extern template NeighbourList<double> find_neighbours(const PointCloud<double>&,
                                                      const PointCloud<double>&,
                                                      const NeighbourRule&,
                                                      const PeriodicDomain<double>&,
                                                      const NeighbourOptions&);

}  // namespace recon
