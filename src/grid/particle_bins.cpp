#include "grid/particle_bins.hpp"

#include <algorithm>
#include <string>

#include "core/instantiate.hpp"
#include "recon/core/error.hpp"
#include "recon/core/parallel.hpp"

namespace recon {
namespace {

using detail::require;

constexpr std::size_t checked_at_once = 16384;
constexpr std::uint32_t most_particles = 0xFFFFFFFFu;

template <class Scalar>
void check_particle(const ParticleData<Scalar>& data, std::size_t p) {
  const auto require_finite = [p](Scalar value, const std::string& what) {
    if (!std::isfinite(value))
      detail::throw_invalid(what + std::to_string(p), value, "must be finite");
  };
  for (int d = 0; d < data.points.dimension(); ++d)
    require_finite(data.points(p, d), "coordinate " + std::to_string(d) + " of point ");
  for (std::size_t f = 0; f < data.fields.size(); ++f)
    for (int c = 0; c < data.fields[f].components(); ++c)
      require_finite(data.fields[f](p, c), "component " + std::to_string(c) + " of field " +
                                               std::to_string(f) + " at point ");
}

// x - x is 0 for finite numbers and NaN for others: one test for a block of particles.
template <class Scalar>
void check(const ParticleData<Scalar>& data, std::size_t begin, std::size_t end) {
  Scalar sum = 0;
  for (int d = 0; d < data.points.dimension(); ++d)
    for (std::size_t p = begin; p < end; ++p) sum += data.points(p, d) - data.points(p, d);
  for (const auto& field : data.fields)
    for (std::size_t p = begin; p < end; ++p)
      for (int c = 0; c < field.components(); ++c) sum += field(p, c) - field(p, c);
  if (sum == 0) return;
  for (std::size_t p = begin; p < end; ++p) check_particle(data, p);
}

// The bins of the particles of [begin, end), and `nowhere` for those that no node sees. Axis by axis,
// because then nothing depends on the particle before.
template <class Scalar>
void find_bins(const PointsView<Scalar>& points, const GridPlan<Scalar>& plan,
               const std::array<std::uint32_t, max_dimension>& strides, std::uint32_t nowhere,
               std::size_t begin, std::size_t end, std::span<std::uint32_t> bins) {
  constexpr std::size_t at_once = 512;
  std::array<std::uint32_t, at_once> bin;
  std::array<bool, at_once> seen;
  for (; begin < end; begin += at_once) {
    const std::size_t count = std::min(at_once, end - begin);
    bin.fill(0);
    seen.fill(true);
    for (int d = 0; d < plan.dimension(); ++d) {
      const GridAxis axis = plan.axes[d];
      const std::uint32_t stride = strides[d];
      const int cells_together = d == 0 ? ParticleBins::cells_per_bin : 1;
      for (std::size_t i = 0; i < count; ++i) {
        const std::int64_t k = axis.cell(static_cast<double>(points(begin + i, d)));
        seen[i] = seen[i] && k >= 0;
        bin[i] +=
            static_cast<std::uint32_t>(k) / static_cast<std::uint32_t>(cells_together) * stride;
      }
    }
    for (std::size_t i = 0; i < count; ++i) bins[begin + i] = seen[i] ? bin[i] : nowhere;
  }
}

}  // namespace

template <class Scalar>
void ParticleData<Scalar>::validate(int dimension, int threads) const {
  const std::size_t n = points.size();
  require(n < most_particles, "points", n, "must be fewer than 2^32 - 1 points");
  require(points.dimension() == dimension, "dimension of the points", points.dimension(),
          "must be that of the grid");
  for (const auto& field : fields)
    require(field.size() == n, "size of the field", field.size(),
            "must be the number of particles");
  require(weights.empty() || weights.size() == n, "number of particle_weights", weights.size(),
          "must be the number of particles, or 0");
  parallel_blocks(n, checked_at_once, threads,
                  [&](std::size_t begin, std::size_t end) { check(*this, begin, end); });
}

template <class Scalar>
ParticleBins::ParticleBins(const ParticleData<Scalar>& data, const GridPlan<Scalar>& plan) {
  const std::size_t n = data.points.size();
  const int threads = plan.options.threads > 0 ? plan.options.threads : default_threads();
  rows_ = plan.axes[1].cells;
  bins_per_row_ = (plan.axes[0].cells + cells_per_bin - 1) / cells_per_bin;
  const auto bins = static_cast<std::size_t>(bins_per_row_ * rows_ * plan.axes[2].cells);
  require(bins < most_particles, "grid", bins, "must have fewer rows of cells (2^32)");
  const std::array<std::uint32_t, max_dimension> strides{
      1, static_cast<std::uint32_t>(bins_per_row_),
      static_cast<std::uint32_t>(bins_per_row_ * rows_)};

  const std::span<std::uint32_t> bin_of = sort_.keys(n);
  parallel_blocks(n, checked_at_once, threads, [&](std::size_t begin, std::size_t end) {
    find_bins(data.points, plan, strides, static_cast<std::uint32_t>(bins), begin, end, bin_of);
  });
  sort_.sort(bins + 1, threads);  // the last bin holds those that are nowhere
  sort_.forget_scratch();
}

RECON_FLOAT(template struct ParticleData<float>;)
template struct ParticleData<double>;
RECON_FLOAT(template ParticleBins::ParticleBins(const ParticleData<float>&,
                                                const GridPlan<float>&);)
template ParticleBins::ParticleBins(const ParticleData<double>&, const GridPlan<double>&);

}  // namespace recon
