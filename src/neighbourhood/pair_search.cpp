#include "neighbourhood/pair_search.hpp"

#include <algorithm>
#include <cmath>
#include <compare>
#include <vector>

#include "core/instantiate.hpp"
#include "neighbourhood/find_with_index.hpp"
#include "recon/core/progress.hpp"
#include "recon/neighbourhood/find_neighbours_with.hpp"

namespace recon::detail {
namespace {

struct Seen {
  ParticleIndex particle;
  ImageShift shift;  // zero in domains that are not periodic

  auto operator<=>(const Seen&) const = default;
};

// The particles that reach each target, in order. `reached` lists the targets that each particle
// reaches: where the image of a target with shift s is near a particle, the image of the particle
// with shift -s is near the target.
template <class Scalar>
std::vector<std::vector<Seen>> turned_round(const NeighbourList<Scalar>& reached,
                                            std::size_t targets) {
  std::vector<std::vector<Seen>> seen(targets);
  for (std::size_t p = 0; p < reached.targets(); ++p)
    for (std::int64_t e = reached.offsets[p]; e < reached.offsets[p + 1]; ++e) {
      ImageShift shift{};
      if (!reached.shifts.empty())
        for (int d = 0; d < max_dimension; ++d)
          shift[d] = static_cast<std::int8_t>(-reached.shifts[e][d]);
      seen[reached.indices[e]].push_back({static_cast<ParticleIndex>(p), shift});
    }
  if (!reached.shifts.empty())
    for (std::vector<Seen>& row : seen) std::sort(row.begin(), row.end());
  return seen;
}

// The rule under which the particles, as targets, find what they reach.
NeighbourRule of_particles_alone(const NeighbourRule& rule) {
  if (const auto* radii = std::get_if<PairRadii>(&rule)) return Radii{radii->particles};
  return Ellipsoids{std::get<PairEllipsoids>(rule).particles};
}

}  // namespace

bool finds_pairs(const NeighbourRule& rule) {
  const auto* ellipsoids = std::get_if<PairEllipsoids>(&rule);
  return std::holds_alternative<PairRadii>(rule) ||
         (ellipsoids && ellipsoids->support == PairSupport::particle);
}

template <int D, class Scalar>
void find_pairs(SearchIndex<Scalar, D>& index, const PointCloud<Scalar>& targets,
                const NeighbourRule& rule, const PeriodicDomain<Scalar>& domain,
                const NeighbourOptions& options, NeighbourList<Scalar>& list) {
  const PointCloud<Scalar>& particles = index.cloud();
  const auto* radii = std::get_if<PairRadii>(&rule);
  // Two searches are told of as one.
  const bool symmetric = radii && radii->support != PairSupport::particle;
  NeighbourOptions of_targets = options, of_particles = options;
  of_particles.progress = part_of(options.progress, 0, symmetric ? 0.5 : 1);
  of_targets.progress = part_of(options.progress, 0.5, 1);
  if (options.visible)
    of_particles.visible = [&](std::size_t particle, std::size_t target) {
      return options.visible(target, particle);
    };
  SearchIndex<Scalar, D> target_index(targets);
  NeighbourList<Scalar> found;
  find_with_index<D>(target_index, particles, of_particles_alone(rule), domain, of_particles, {},
                     found);
  std::vector<std::vector<Seen>> rows = turned_round(found, targets.size());

  if (symmetric) {
    find_with_index<D>(index, targets, Radii{radii->targets}, domain, of_targets, {}, found);
    std::vector<Seen> own, both;
    for (std::size_t t = 0; t < rows.size(); ++t) {
      own.clear();
      for (std::int64_t e = found.offsets[t]; e < found.offsets[t + 1]; ++e)
        own.push_back({found.indices[e], found.shifts.empty() ? ImageShift{} : found.shifts[e]});
      both.clear();
      std::set_union(rows[t].begin(), rows[t].end(), own.begin(), own.end(),
                     std::back_inserter(both));
      rows[t] = both;
    }
  }
  if (radii && radii->support == PairSupport::mean) {
    const bool cube = options.shape == SupportShape::cube;
    for (std::size_t t = 0; t < rows.size(); ++t)
      std::erase_if(rows[t], [&](const Seen& seen) {
        const Scalar rho = pair_radius<Scalar>(*radii, t, seen.particle);
        Scalar distance2 = 0, along_axis = 0;
        for (int d = 0; d < D; ++d) {
          Scalar x = targets(t, d);
          if (domain.periodic[d]) x -= static_cast<Scalar>(seen.shift[d]) * domain.period(d);
          const Scalar along = x - particles(seen.particle, d);
          distance2 += along * along;
          along_axis = std::max(along_axis, std::abs(along));
        }
        return cube ? along_axis > rho : distance2 > rho * rho;
      });
  }

  list.offsets.resize(rows.size() + 1);
  list.offsets[0] = 0;
  for (std::size_t t = 0; t < rows.size(); ++t)
    list.offsets[t + 1] = list.offsets[t] + static_cast<std::int64_t>(rows[t].size());
  list.indices.resize(static_cast<std::size_t>(list.offsets.back()));
  list.shifts.resize(domain.any() ? list.indices.size() : 0);
  std::size_t entry = 0;
  for (const std::vector<Seen>& row : rows)
    for (const Seen& seen : row) {
      list.indices[entry] = seen.particle;
      if (domain.any()) list.shifts[entry] = seen.shift;
      ++entry;
    }
  list.support_factor = 0;
  add_supports(rule, D, options.threads, list);
}

#define RECON_INSTANTIATE(S, D)                                                                  \
  template void find_pairs<D, S>(SearchIndex<S, D>&, const PointCloud<S>&, const NeighbourRule&, \
                                 const PeriodicDomain<S>&, const NeighbourOptions&,              \
                                 NeighbourList<S>&)
RECON_FOR_EACH_SCALAR_AND_DIMENSION(RECON_INSTANTIATE);
#undef RECON_INSTANTIATE

}  // namespace recon::detail
