// The particles of a row of cells, dealt out to lanes and slots as the kernels want them.
//
// A row with very many particles comes in several portions, cut by their number alone.
#pragma once

#include <algorithm>
#include <utility>

#include "grid/aligned_array.hpp"
#include "grid/sweep.hpp"

namespace recon {

template <class Scalar>
class RowGather {
 public:
  // `first`: the first node of the tile along the first axis, hence also its first cell.
  RowGather(const ParticleData<Scalar>& particles, const ParticleBins& bins,
            const GridPlan<Scalar>& plan, const LaneLayout& lanes, std::int64_t first)
      : particles_(particles),
        bins_(bins),
        plan_(plan),
        lanes_(lanes),
        first_(first),
        cells_(std::min<std::int64_t>(std::int64_t{lanes.groups} * lanes.lanes,
                                      plan.axes[0].cells - first)),
        portion_(static_cast<std::size_t>(16 * cells_ + 64)),
        slot_size_(
            static_cast<std::size_t>((plan.dimension() + 1 + plan.components) * lanes.lanes)),
        cell_(portion_),
        at_(portion_),
        place_(static_cast<std::size_t>(cells_)),
        particle_(portion_),
        begin_(static_cast<std::size_t>(lanes.groups) + 1) {
    for (const auto& field : particles.fields)
      for (int c = 0; c < field.components(); ++c)
        columns_.push_back({static_cast<const std::byte*>(field.first(c)), field.point_stride()});
  }

  void start(std::int64_t j, std::int64_t k) {
    row_ = {first_, j, k};
    left_ = bins_.row(first_, first_ + cells_, j, k);
  }

  // The next portion; false where there is none.
  bool next() {
    if (left_.empty()) return false;
    const std::size_t count = std::min(portion_, left_.size());
    const auto chosen = left_.first(count);
    left_ = left_.subspan(count);
    count_slots(chosen);
    fill_slots(chosen);
    return true;
  }

  // Does another portion follow?
  bool more() const { return !left_.empty(); }

  const std::uint32_t* begin() const { return begin_.data(); }
  const Scalar* slots() const { return slots_.data(); }

 private:
  struct Column {
    const std::byte* base;
    std::ptrdiff_t stride;
    const Scalar* at(std::size_t p) const {
      return reinterpret_cast<const Scalar*>(base + static_cast<std::ptrdiff_t>(p) * stride);
    }
  };
  static constexpr std::size_t elsewhere = ~std::size_t{0};

  // Finds the cell of each particle within the tile, and the slots that each group needs: as many
  // as its fullest lane has particles. Also prefetches the data of the particles.
  void count_slots(std::span<const std::uint32_t> chosen) {
    std::fill(place_.begin(), place_.end(), std::size_t{0});
    const GridAxis axis = plan_.axes[0];
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      const std::int64_t cell =
          axis.cell(static_cast<double>(particles_.points(chosen[i], 0))) - first_;
      const bool here = cell >= 0 && cell < cells_;
      at_[i] = here ? static_cast<std::size_t>(cell) : elsewhere;
      if (!here) continue;
      ++place_[static_cast<std::size_t>(cell)];
      for (const Column& column : columns_) __builtin_prefetch(column.at(chosen[i]));
    }
    std::size_t total = 0;
    const auto groups = static_cast<std::size_t>(lanes_.groups);
    for (std::size_t g = 0; g < groups; ++g) {
      begin_[g] = static_cast<std::uint32_t>(total);
      std::size_t most = 0, lane = 0;
      for (std::size_t cell = g; cell < place_.size(); cell += groups) {
        most = std::max(most, place_[cell]);
        place_[cell] = total * slot_size_ + lane++;
      }
      total += most;
    }
    begin_.back() = static_cast<std::uint32_t>(total);
  }

  void fill_slots(std::span<const std::uint32_t> chosen) {
    slots_.reset(begin_.back() * slot_size_);
    std::size_t count = 0;
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      if (at_[i] == elsewhere) continue;
      cell_[count] = static_cast<std::int64_t>(at_[i]);
      particle_[count] = chosen[i];
      at_[count++] = std::exchange(place_[at_[i]], place_[at_[i]] + slot_size_);
    }
    // One kind of number after another: each loop is short, and no particle waits for
    // the one before.
    Scalar* to = slots_.data();
    const auto fill = [&](const auto& value) {
      for (std::size_t i = 0; i < count; ++i) to[at_[i]] = value(i);
      to += lanes_.lanes;
    };
    for (int d = 0; d < plan_.dimension(); ++d) {
      const GridAxis axis = plan_.axes[d];
      fill([&, d, row = row_[d], along = std::int64_t{d == 0}](std::size_t i) {
        const auto x = static_cast<double>(particles_.points(particle_[i], d));
        return static_cast<Scalar>(axis.offset(x, row + along * cell_[i]));
      });
    }
    if (!particles_.weights.empty())
      fill([&](std::size_t i) { return particles_.weight(particle_[i]); });
    else
      fill([](std::size_t) { return Scalar(1); });
    for (const Column column : columns_)
      fill([&](std::size_t i) { return *column.at(particle_[i]); });
  }

  const ParticleData<Scalar>& particles_;
  const ParticleBins& bins_;
  const GridPlan<Scalar>& plan_;
  LaneLayout lanes_;
  std::int64_t first_, cells_;
  std::size_t portion_;
  std::size_t slot_size_;
  std::vector<Column> columns_;
  std::array<std::int64_t, max_dimension> row_{};  // the first cell
  std::span<const std::uint32_t> left_;
  std::vector<std::int64_t> cell_;  // of each particle, from first_
  std::vector<std::size_t> at_,
      place_;  // where the numbers of a particle go, and those of the next one of a cell
  std::vector<std::uint32_t> particle_, begin_;
  AlignedArray<Scalar> slots_;
};

}  // namespace recon
