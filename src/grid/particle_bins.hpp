// The particles sorted by the cells that they lie in, as indices: 4 bytes for each.
//
// A bin is a row of 8 cells along the first axis; rows of cells are ranges of bins. Within a bin
// particles keep the order of the input, so that sums have a fixed order.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/counting_sort.hpp"
#include "grid/grid_plan.hpp"
#include "recon/points/view.hpp"

namespace recon {

// The input of a reconstruction: positions, data, and weights of the particles (none: all 1).
template <class Scalar>
struct ParticleData {
  PointsView<Scalar> points;
  std::vector<FieldView<Scalar>> fields;
  std::span<const double> weights;
  // Multiplies the weights: a power of two that brings the largest to the order of one.
  double weight_scale = 1;

  Scalar weight(std::size_t p) const { return static_cast<Scalar>(weights[p] * weight_scale); }

  // Throws InvalidArgument for sizes that differ, another dimension, and numbers that are not
  // finite (naming the particle and the axis or component). The values of the weights are checked
  // with the options.
  void validate(int dimension, int threads) const;

  int components() const {
    int sum = 0;
    for (const auto& field : fields) sum += field.components();
    return sum;
  }
};

class ParticleBins {
 public:
  static constexpr int cells_per_bin = 8;

  // Of valid particles. Throws InvalidArgument for grids with too many rows of cells.
  template <class Scalar>
  ParticleBins(const ParticleData<Scalar>& particles, const GridPlan<Scalar>& plan);

  // The particles of the bins that hold the cells [begin, end) of row (j, k), and so some
  // of other cells.
  std::span<const std::uint32_t> row(std::int64_t begin, std::int64_t end, std::int64_t j,
                                     std::int64_t k) const {
    const std::size_t first = static_cast<std::size_t>((k * rows_ + j) * bins_per_row_);
    const std::span<const std::uint32_t> place = sort_.first();
    const std::uint32_t from = place[first + static_cast<std::size_t>(begin / cells_per_bin)];
    const std::uint32_t to = place[first + static_cast<std::size_t>((end - 1) / cells_per_bin) + 1];
    return sort_.order().subspan(from, to - from);
  }

 private:
  std::int64_t bins_per_row_, rows_;
  detail::CountingSort sort_;
};

extern template struct ParticleData<float>;
extern template struct ParticleData<double>;
extern template ParticleBins::ParticleBins(const ParticleData<float>&, const GridPlan<float>&);
extern template ParticleBins::ParticleBins(const ParticleData<double>&, const GridPlan<double>&);

}  // namespace recon
