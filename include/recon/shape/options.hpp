// All choices of a reconstruction, with defaults that work: one set for lists of targets and for
// grids.
//
// What is left empty becomes what the targets need:
//                points                                 nodes of a StructuredGrid
//   form         radial                                 tensor_product
//   neighbours   the nearest 2 * terms + 1 particles    the natural support of the B-spline
//   solver       gram_schmidt                           moment_matrix; for degree > 2 gram_schmidt
// The natural support of the B-spline of degree P is (P + 1) / 2 spacings of the grid along each
// axis, times `stretch`: weights are then the cardinal splines of the material point method
// (Steffen, Kirby, Berzins 2008), which sum to one over the grid.
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <span>

#include "recon/core/instruction_set.hpp"
#include "recon/core/progress.hpp"
#include "recon/local_solve/local_cloud.hpp"
#include "recon/neighbourhood/find_neighbours.hpp"
#include "recon/neighbourhood/sources.hpp"
#include "recon/points/domain.hpp"
#include "recon/points/structured_grid.hpp"
#include "recon/weights/weight.hpp"

namespace recon {

// The value of a target without any particle in its support.
enum class Unsupported {
  fill,    // apply() writes Options::fill_value there
  nearest  // the value of the nearest particle (of the smallest index, if several are)
};

// Growing supports: a target that does not reach the asked degree is tried again with its
// support (for nearest neighbours: their number) enlarged by `factor`, up to `steps` times. A
// target that never reaches it keeps its first support, so that a cloud on a line is not
// smoothed without any gain.
struct Growth {
  int steps = 0;
  double factor = 1.25;
};

struct Options {
  // Polynomials of degree up to this are reproduced: 0 (Shepard) to 4.
  int degree = 1;
  // w(q), q = |x - x_p| / rho; an enumerator or any object that is a RadialWeight.
  WeightFunction weight = Weight::cubic_b_spline;
  // radial: the support is a ball; tensor_product: a cube. With `stretch` ellipsoids and boxes.
  std::optional<WeightForm> form{};
  // m_p, one number for each particle: see SourcesOptions, whose members this, `stretch` and
  // `domain` are. They belong to the particles: calls that take Sources have them from there, and
  // throw InvalidArgument where they are said here.
  std::span<const double> particle_weights{};
  // Radius{rho}, Radii{per target}, Nearest{k, factor}, NearestWithin{k, rho}, PairRadii{per
  // particle}; for ellipsoids of any orientation Ellipsoids{per target} and, with radial weights,
  // PairEllipsoids{per particle}; lengths. The support of Nearest moves with the k-th neighbour,
  // and exact gradients with it; all others, and those of a list of your own unless it says
  // otherwise, stand still (NeighbourList::support_factor).
  std::optional<NeighbourRule> neighbours{};
  std::optional<Solver> solver{};

  // Along axis d supports are rho * stretch[d]: Radius{1} and stretch {a, b, c} are supports of the
  // half axes a, b, c, lengths. Tensors of ellipsoids are those of the coordinates divided by it.
  std::array<double, max_dimension> stretch{1, 1, 1};
  PeriodicDomain<double> domain{};
  SearchMethod search = SearchMethod::automatic;
  // visible(target, particle) == false hides a particle from a target. Called concurrently.
  Visibility visible{};

  // Targets farther from every particle (that they see) than this many local spacings are not
  // extrapolated to: their status is too_far, and they get fill_value, whatever `unsupported` says.
  // The local spacing is the distance from the nearest particle to its (2 D + 3)rd neighbour, the
  // last that a linear fit takes by default; copies at one place count once, and with `stretch`
  // distances are those in stretched coordinates. No target among dense particles in 2-D and 3-D is
  // as far as 2. Infinity: no limit.
  double max_distance = std::numeric_limits<double>::infinity();

  Growth grow{};
  Unsupported unsupported = Unsupported::fill;
  double fill_value = std::numeric_limits<double>::quiet_NaN();

  FitTolerances tolerances{};
  int threads = 0;  // 0: default_threads(); the results do not depend on it
  InstructionSet instruction_set = InstructionSet::automatic;
  // Told how far the making of a reconstruction, or an update of it, has come; can cancel that.
  Progress progress{};

  SourcesOptions sources() const { return {domain, stretch, particle_weights, threads}; }

  // The same with nothing left empty, for targets that are points in so many dimensions, and for
  // the nodes of a grid. On a grid whose spacings differ the natural supports do too: they are said
  // through `stretch`. Throws InvalidArgument as validate() does, for a bad grid, and on a grid
  // without a rule for weights that are no B-splines.
  Options for_points(int dimension) const;
  template <class Scalar>
  Options for_grid(const StructuredGrid<Scalar>& grid) const;

  // Throws InvalidArgument for a value outside its range. Rules about neighbours are checked when
  // they are searched, the number of particle weights when the particles are known.
  void validate() const;
  // Throws InvalidArgument where something is said that belongs to Sources.
  void validate_with_sources() const;
};

extern template Options Options::for_grid(const StructuredGrid<float>&) const;
extern template Options Options::for_grid(const StructuredGrid<double>&) const;

}  // namespace recon
