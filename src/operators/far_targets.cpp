#include "operators/far_targets.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/instantiate.hpp"
#include "operators/list_rows.hpp"
#include "recon/core/parallel.hpp"

namespace recon::detail {
namespace {

constexpr std::size_t targets_per_block = 256;

// Of a target: the nearest particle, how far it is, and a distance that the local spacing there is
// known to reach (0: nothing is known).
template <class Scalar>
struct Nearness {
  ParticleIndex particle = 0;
  Scalar distance = std::numeric_limits<Scalar>::infinity(), spacing = 0;

  bool found() const { return !std::isinf(distance); }
};

template <class Scalar>
class FarTargets {
 public:
  FarTargets(const Cloud<Scalar>& cloud, const PointCloud<Scalar>& targets,
             const NeighbourOptions& search)
      : cloud_(cloud),
        particles_(cloud.points()),
        targets_(targets),
        domain_(cloud.domain()),
        search_(search) {
    search_.shape = SupportShape::ball;
  }

  std::vector<std::size_t> find(const NeighbourList<Scalar>& neighbours, Scalar multiple,
                                bool complete) const {
    std::vector<Nearness<Scalar>> near(targets_.size());
    recon::parallel_blocks(targets_.size(), targets_per_block, search_.threads,
                           [&](std::size_t begin, std::size_t end) {
                             std::vector<Scalar> squares;
                             for (std::size_t t = begin; t < end; ++t)
                               near[t] = nearness_in_list(t, neighbours, complete, squares);
                           });
    find_the_rest(near);

    // The spacing is looked up where the lists have not shown it to be large enough.
    const auto is_near = [&](const Nearness<Scalar>& n, Scalar spacing) {
      return !n.found() || n.distance <= multiple * spacing;
    };
    std::vector<std::size_t> asked, place(particles_.size(), particles_.size());
    for (const Nearness<Scalar>& n : near) {
      if (is_near(n, n.spacing) || place[n.particle] < particles_.size()) continue;
      place[n.particle] = asked.size();
      asked.push_back(n.particle);
    }
    const std::vector<Scalar> spacing = spacings_at(asked);
    std::vector<std::size_t> far;
    for (std::size_t t = 0; t < near.size(); ++t)
      if (!is_near(near[t], near[t].spacing) && !is_near(near[t], spacing[place[near[t].particle]]))
        far.push_back(t);
    return far;
  }

 private:
  using Offset = std::array<Scalar, max_dimension>;

  // The local spacing is the distance to the neighbour of this number.
  std::size_t spacing_neighbour() const {
    return 2 * static_cast<std::size_t>(particles_.dimension()) + 3;
  }

  // From target number t of `at` to the particle of an entry.
  Offset offset(const PointCloud<Scalar>& at, std::size_t t, const NeighbourList<Scalar>& list,
                std::int64_t entry) const {
    Offset to{};
    for (int d = 0; d < particles_.dimension(); ++d) {
      to[d] = particles_(list.indices[entry], d) - at(t, d);
      if (!list.shifts.empty() && domain_.periodic[d])
        to[d] += list.shifts[entry][d] * domain_.period(d);
    }
    return to;
  }

  static Scalar square(const Offset& offset) {
    Scalar sum = 0;
    for (const Scalar along : offset) sum += along * along;
    return sum;
  }

  // From the target's list; nothing where another particle may be nearer than those in it. If the
  // k-th is at a distance r, then fewer than k particles of a complete list are within r - distance
  // of the nearest.
  Nearness<Scalar> nearness_in_list(std::size_t t, const NeighbourList<Scalar>& list, bool complete,
                                    std::vector<Scalar>& squares) const {
    // A particle with a small support of its own may be nearer than all in the list, and so may one
    // beside an ellipsoid.
    if (!list.pair_support.empty() || !list.tensor.empty() || !list.pair_tensor.empty()) return {};
    Nearness<Scalar> near;
    squares.clear();
    Scalar least = std::numeric_limits<Scalar>::infinity();
    for (std::int64_t e = list.offsets[t]; e < list.offsets[t + 1]; ++e) {
      squares.push_back(square(offset(targets_, t, list, e)));
      if (squares.back() < least) {
        least = squares.back();
        near.particle = list.indices[e];
      }
    }
    if (squares.empty() || !(std::sqrt(least) <= list.support[t])) return {};
    near.distance = std::sqrt(least);
    if (!complete) return near;
    const std::size_t k = std::min(spacing_neighbour(), squares.size()) - 1;
    std::nth_element(squares.begin(), squares.begin() + static_cast<std::ptrdiff_t>(k),
                     squares.end());
    near.spacing = std::sqrt(squares[k]) - near.distance;
    return near;
  }

  // The nearest particles of the targets whose lists do not tell.
  void find_the_rest(std::vector<Nearness<Scalar>>& near) const {
    std::vector<std::size_t> rest;
    for (std::size_t t = 0; t < near.size(); ++t)
      if (!near[t].found()) rest.push_back(t);
    if (rest.empty()) return;
    NeighbourOptions search = search_;
    if (search_.visible)
      search.visible = [&](std::size_t t, std::size_t p) { return search_.visible(rest[t], p); };
    const PointCloud<Scalar> at = subset(targets_, rest);
    NeighbourList<Scalar> list;
    cloud_.find(at, Nearest{1}, search, {.in_order = true}, list);
    for (std::size_t i = 0; i < rest.size(); ++i)
      if (list.count(i) > 0)
        near[rest[i]] = {list.indices[list.offsets[i]],
                         std::sqrt(square(offset(at, i, list, list.offsets[i]))), 0};
  }

  // The local spacings at some particles; where there are too few others, the distance to the
  // farthest.
  std::vector<Scalar> spacings_at(const std::vector<std::size_t>& chosen) const {
    NeighbourOptions all = search_;
    all.visible = {};
    std::vector<Scalar> spacings(chosen.size());
    std::vector<std::size_t> rest(chosen.size());
    for (std::size_t i = 0; i < rest.size(); ++i) rest[i] = i;
    for (std::size_t ask = spacing_neighbour() + 1; !rest.empty(); ask *= 4) {
      std::vector<std::size_t> asked, still;
      for (const std::size_t i : rest) asked.push_back(chosen[i]);
      const PointCloud<Scalar> at = subset(particles_, asked);
      NeighbourList<Scalar> list;
      cloud_.find(at, Nearest{ask}, all, {.in_order = true}, list);
      for (std::size_t i = 0; i < rest.size(); ++i) {
        const bool found = spacing_in_list(at, i, list, spacings[rest[i]]);
        if (!found && static_cast<std::size_t>(list.count(i)) == ask) still.push_back(rest[i]);
      }
      rest = std::move(still);
    }
    return spacings;
  }

  // From the nearest of a particle, by distance. False where they are too few; then the farthest
  // distance.
  bool spacing_in_list(const PointCloud<Scalar>& at, std::size_t t,
                       const NeighbourList<Scalar>& list, Scalar& spacing) const {
    std::vector<Offset> same;  // places at the present distance
    Scalar present = -1;
    std::size_t places = 0;
    for (std::int64_t e = list.offsets[t]; e < list.offsets[t + 1]; ++e) {
      const Offset place = offset(at, t, list, e);
      if (square(place) != present) same.clear();
      present = square(place);
      if (std::find(same.begin(), same.end(), place) != same.end()) continue;
      same.push_back(place);
      if (++places <= spacing_neighbour()) continue;  // the particle itself is the first
      spacing = std::sqrt(present);
      return true;
    }
    spacing = std::sqrt(std::max(present, Scalar(0)));
    return false;
  }

  const Cloud<Scalar>& cloud_;
  const PointCloud<Scalar>& particles_;
  const PointCloud<Scalar>& targets_;
  const PeriodicDomain<Scalar>& domain_;
  NeighbourOptions search_;
};

}  // namespace

template <class Scalar>
std::vector<std::size_t> far_targets(const Cloud<Scalar>& cloud, const PointCloud<Scalar>& targets,
                                     const NeighbourList<Scalar>& neighbours, double multiple,
                                     bool complete, const NeighbourOptions& search) {
  const PointCloud<Scalar>& particles = cloud.points();
  bool extended = false;
  for (int d = 0; d < particles.dimension() && particles.size() > 0; ++d)
    extended = extended || cloud.domain().periodic[d] || particles.box().extent(d) > 0;
  if (std::isinf(multiple) || !extended) return {};
  return FarTargets<Scalar>(cloud, targets, search)
      .find(neighbours, static_cast<Scalar>(multiple), complete && !search.visible);
}

#define RECON_INSTANTIATE(S)                                                           \
  template std::vector<std::size_t> far_targets(const Cloud<S>&, const PointCloud<S>&, \
                                                const NeighbourList<S>&, double, bool, \
                                                const NeighbourOptions&)
RECON_FLOAT(RECON_INSTANTIATE(float);)
RECON_INSTANTIATE(double);
#undef RECON_INSTANTIATE

}  // namespace recon::detail
