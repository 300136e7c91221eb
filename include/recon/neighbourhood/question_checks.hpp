// What find_neighbours refuses: rules with values outside their range, and clouds that do not go
// with each other or with the periodic domain. All throw InvalidArgument.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <variant>

#include "recon/core/error.hpp"
#include "recon/neighbourhood/find_neighbours.hpp"

namespace recon::detail {

// The k of a nearest rule; a negative one has become a large number.
inline void require_count(std::size_t k) {
  require(k >= 1, "k", k, "must be at least 1");
  require(k <= 0xFFFFFFFFu, "k", static_cast<std::int64_t>(k), "must be from 1 to 2^32 - 1");
}

// Throws InvalidArgument for values outside their range and numbers of radii or tensors that are
// not those of the targets and particles.
template <class Scalar>
void require_valid_rule(const NeighbourRule& rule, int dimension, std::size_t targets,
                        std::size_t particles) {
  const auto positive = [](double length) {  // in the scalar type of the points
    const auto rounded = static_cast<Scalar>(length);
    return rounded > 0 && std::isfinite(rounded) &&
           rounded * rounded >= std::numeric_limits<Scalar>::min();
  };
  const char* const length_rule =
      "must be positive and finite, and not so small that its square underflows";
  const auto require_radii = [&](std::span<const double> radii, const char* of, const char* one,
                                 std::size_t number, const char* number_rule) {
    require(radii.size() == number, of, radii.size(), number_rule);
    for (std::size_t i = 0; i < number; ++i)
      if (!positive(radii[i])) throw_invalid(one + std::to_string(i), radii[i], length_rule);
  };
  if (const auto* radius = std::get_if<Radius>(&rule)) {
    require(positive(radius->radius), "radius", radius->radius, length_rule);
  } else if (const auto* radii = std::get_if<Radii>(&rule)) {
    require_radii(radii->radii, "number of radii", "radius of target ", targets,
                  "must be the number of targets");
  } else if (const auto* pairs = std::get_if<PairRadii>(&rule)) {
    require(pairs->support >= PairSupport::particle && pairs->support <= PairSupport::larger,
            "support of pairs", static_cast<int>(pairs->support),
            "must be an enumerator of recon::PairSupport");
    require_radii(pairs->particles, "number of radii of particles", "radius of particle ",
                  particles, "must be the number of particles");
    const bool symmetric = pairs->support != PairSupport::particle;
    require_radii(pairs->targets, "number of radii of targets", "radius of target ",
                  symmetric ? targets : 0,
                  symmetric ? "must be the number of targets"
                            : "must be 0 where pairs have the support of the particle");
  } else if (const auto* nearest = std::get_if<Nearest>(&rule)) {
    require_count(nearest->k);
    require(nearest->factor > 1 && std::isfinite(nearest->factor), "factor", nearest->factor,
            "must be larger than 1 and finite");
  } else if (const auto* near_within = std::get_if<NearestWithin>(&rule)) {
    require_count(near_within->k);
    require(positive(near_within->radius), "radius", near_within->radius, length_rule);
  } else if (const auto* ellipsoids = std::get_if<Ellipsoids>(&rule)) {
    require_tensors<Scalar>(ellipsoids->tensors, dimension, targets, "target ",
                            "must be the number of targets");
  } else if (const auto* pair_ellipsoids = std::get_if<PairEllipsoids>(&rule)) {
    require(pair_ellipsoids->support == PairSupport::particle ||
                pair_ellipsoids->support == PairSupport::mean,
            "support of pairs", static_cast<int>(pair_ellipsoids->support),
            "must be PairSupport::particle or mean: of two ellipsoids neither is the larger");
    require_tensors<Scalar>(pair_ellipsoids->particles, dimension, particles, "particle ",
                            "must be the number of particles");
    const bool symmetric = pair_ellipsoids->support == PairSupport::mean;
    require_tensors<Scalar>(pair_ellipsoids->targets, dimension, symmetric ? targets : 0, "target ",
                            symmetric ? "must be the number of targets"
                                      : "must be 0 where pairs have the support of the particle");
  }
}

template <class Scalar>
void require_in_domain(const Box<Scalar>& box, const PeriodicDomain<Scalar>& domain,
                       const char* name) {
  for (int d = 0; d < box.dimension && !box.is_empty(); ++d) {
    if (!domain.periodic[d]) continue;
    require(box.lower[d] >= domain.lower[d], name, box.lower[d], "must lie in the periodic domain");
    require(box.upper[d] <= domain.upper[d], name, box.upper[d], "must lie in the periodic domain");
  }
}

// Throws InvalidArgument unless rule, clouds and domain are as find_neighbours.hpp asks for.
template <class Scalar>
void require_valid_question(const PointCloud<Scalar>& particles, const PointCloud<Scalar>& targets,
                            const NeighbourRule& rule, const PeriodicDomain<Scalar>& domain,
                            SupportShape shape) {
  require(targets.dimension() == particles.dimension(), "dimension of the targets",
          targets.dimension(), "must be the dimension of the particles");
  require_valid_rule<Scalar>(rule, particles.dimension(), targets.size(), particles.size());
  require(shape == SupportShape::ball || !std::holds_alternative<PairEllipsoids>(rule),
          "support shape", "cube", "must be a ball for PairEllipsoids");
  domain.validate(particles.dimension());
  // Where all squared distances underflow, none is the nearest.
  Scalar extent = 0;
  for (int d = 0; d < particles.dimension() && particles.size() > 0; ++d)
    extent = std::max(extent, particles.box().extent(d));
  require(extent == 0 || extent * extent >= std::numeric_limits<Scalar>::min(),
          "extent of the particles", extent, "must not be so small that its square underflows");
  require_in_domain(particles.box(), domain, "particle coordinate");
  require_in_domain(targets.box(), domain, "target coordinate");
}

}  // namespace recon::detail
