// Sources: a cloud of particles, copied, checked and ordered in space once, for any number of
// questions.
//
// ```cpp
// recon::Sources sources(points, {.domain = box});
// auto fit = recon::reconstruct(sources, targets, {.degree = 2});  // any number of times
// sources.update(moved);                                           // the same memory
// fit.update(targets);                                             // the same memory
// ```
//
// Particles keep the caller's numbers in all that is asked and answered. Inside they stand in the
// order of cells of about three particles, and in a cell by their numbers: the order is a function
// of the present positions alone, so Sources that were updated equal new ones in every bit, and so
// do all results. The searches (cells, trees) are built when they are first needed, and kept until
// the next update.
//
// A copy of Sources is the same cloud, not another one: it is owned jointly by all copies and by
// what was made of it. An update makes that stale: a reconstruction or an operator of the positions
// before throws InvalidArgument when it is applied, scaled or added to, or asked for derivatives,
// rows, neighbours or reports. A reconstruction is mended by its own update(), an operator is made
// anew. Nobody may read while somebody updates.
//
// Memory: about 42 bytes for each particle in 3-D (double), and 36 more from the first update on.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "recon/neighbourhood/find_neighbours.hpp"
#include "recon/points/domain.hpp"
#include "recon/points/view.hpp"

namespace recon {

struct SourcesOptions {
  PeriodicDomain<double> domain{};
  // Anisotropic supports: along axis d a support is rho * stretch[d] (all > 0, no unit).
  std::array<double, max_dimension> stretch{1, 1, 1};
  // m_p, one number for each particle, for example its mass or volume: it multiplies w(q) in fits,
  // so that particles count in proportion to it. Positive and finite, none smaller than 1e-30 times
  // the largest; any unit, because only ratios matter. Empty: all ones. Kept as a copy.
  std::span<const double> particle_weights{};
  int threads = 0;  // of sorting; 0: default_threads()

  // Throws InvalidArgument for a value outside its range; the number of weights is checked with the
  // points.
  void validate() const;
};

namespace detail {
template <class Scalar>
class Cloud;
}

template <class Scalar>
class BasicSources {
 public:
  // Throws InvalidArgument for options outside their range, a number of weights that is not that of
  // the points, and coordinates that are not finite (naming the point and the axis).
  explicit BasicSources(const PointsView<Scalar>& points, const SourcesOptions& options = {});

  // The particles are where `points` says; there may be more or fewer. Particle weights stay as
  // they are where none are given, and must be given where their number changes. Throws as the
  // constructor does, and then changes nothing.
  void update(const PointsView<Scalar>& points);
  void update(const PointsView<Scalar>& points, std::span<const double> particle_weights);

  std::size_t size() const;
  int dimension() const;
  const PeriodicDomain<double>& domain() const;

  // order()[i] is the caller's number of the particle that stands at place i.
  std::span<const std::uint32_t> order() const;

  // What the compiled parts of recon read.
  const std::shared_ptr<detail::Cloud<Scalar>>& cloud() const { return cloud_; }

 private:
  std::shared_ptr<detail::Cloud<Scalar>> cloud_;
};

using Sources = BasicSources<double>;
using SourcesF = BasicSources<float>;

extern template class BasicSources<float>;
extern template class BasicSources<double>;

// The neighbours of all targets, in the caller's numbers; see find_neighbours.hpp. Radius and Radii
// list in the order of the Sources, and so do the nearest rules among particles at the same
// distance.
NeighbourList<double> find_neighbours(const Sources& sources, const PointsView<double>& targets,
                                      const NeighbourRule& rule,
                                      const NeighbourOptions& options = {});
NeighbourList<float> find_neighbours(const SourcesF& sources, const PointsView<float>& targets,
                                     const NeighbourRule& rule,
                                     const NeighbourOptions& options = {});

}  // namespace recon
