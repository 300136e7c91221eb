#include "recon/neighbourhood/neighbour_list.hpp"

#include <cmath>
#include <limits>
#include <string>

#include "core/instantiate.hpp"
#include "recon/neighbourhood/support_tensor.hpp"

namespace recon {

namespace {
using detail::require;
}  // namespace

template <class Scalar>
void NeighbourList<Scalar>::validate(std::size_t target_count, std::size_t particle_count) const {
  require(offsets.size() == target_count + 1, "number of offsets", offsets.size(),
          "must be one more than the number of targets");
  require(offsets.front() == 0, "first offset", offsets.front(), "must be 0");
  for (std::size_t t = 0; t < target_count; ++t)
    if (offsets[t + 1] < offsets[t])
      detail::throw_invalid("offset behind target " + std::to_string(t), offsets[t + 1],
                            "must not be smaller than the one before");
  require(offsets.back() == static_cast<std::int64_t>(indices.size()), "last offset",
          offsets.back(), "must be the number of indices");
  for (std::size_t t = 0; t < target_count; ++t)
    for (const ParticleIndex particle : of(t))
      if (particle >= particle_count)
        detail::throw_invalid(
            "neighbour of target " + std::to_string(t), particle,
            "must be smaller than the number of particles, " + std::to_string(particle_count));
  require(shifts.empty() || shifts.size() == indices.size(), "number of shifts", shifts.size(),
          "must be 0 or the number of indices");
  require(support.size() == target_count, "number of supports", support.size(),
          "must be the number of targets");
  const auto require_supports = [](const Array<Scalar>& lengths, const char* whose) {
    for (std::size_t i = 0; i < lengths.size(); ++i) {
      if (!(lengths[i] > 0) || !std::isfinite(lengths[i]))
        detail::throw_invalid(whose + std::to_string(i), lengths[i], "must be positive and finite");
      if (lengths[i] * lengths[i] < std::numeric_limits<Scalar>::min())
        detail::throw_invalid(whose + std::to_string(i), lengths[i],
                              "must not be so small that its square underflows");
    }
  };
  require_supports(support, "support of target ");
  require(pair_support.empty() || pair_support.size() == indices.size(), "number of pair supports",
          pair_support.size(), "must be 0 or the number of indices");
  require_supports(pair_support, "support of entry ");
  require(pair_support.empty() || (tensor.empty() && pair_tensor.empty()),
          "number of pair supports", pair_support.size(), "must be 0 where there are tensors");
  const auto require_number = [](const Array<Scalar>& tensors, std::size_t one_for_each,
                                 const char* name, const char* rule) {
    const std::size_t size = one_for_each > 0 ? tensors.size() / one_for_each : 0;
    require(
        tensors.size() == size * one_for_each && (size == 0 || size == 1 || size == 3 || size == 6),
        name, tensors.size(), rule);
    return detail::tensor_dimension(static_cast<int>(size));
  };
  const int dimension = require_number(tensor, target_count, "numbers in the tensors",
                                       "must be 0, or D (D + 1) / 2 times the number of targets");
  const int pair_dimension =
      require_number(pair_tensor, indices.size(), "numbers in the tensors of pairs",
                     "must be 0, or D (D + 1) / 2 times the number of indices");
  require(dimension == 0 || pair_dimension == 0 || dimension == pair_dimension,
          "dimension of the tensors of pairs", pair_dimension,
          "must be that of the tensors of targets");
  if (dimension > 0) detail::require_packed_tensors(tensor, dimension, "target ");
  if (pair_dimension > 0) detail::require_packed_tensors(pair_tensor, pair_dimension, "entry ");
  require(support_factor == 0 || (support_factor >= 1 && std::isfinite(support_factor)),
          "support_factor of the neighbours", support_factor,
          "must be 0, for supports that stand still, or finite and at least 1");
  require(support_factor == 0 || pair_support.empty(), "support_factor of the neighbours",
          support_factor, "must be 0 where pairs have supports of their own");
  require(support_factor == 0 || (tensor.empty() && pair_tensor.empty()),
          "support_factor of the neighbours", support_factor, "must be 0 where there are tensors");
}

RECON_FLOAT(template struct NeighbourList<float>;)
template struct NeighbourList<double>;

}  // namespace recon
