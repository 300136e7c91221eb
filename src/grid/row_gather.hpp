// The particles of a row of cells, dealt out to lanes and slots as the kernels want them.
//
// Lanes hold cells, so a row with many particles comes in portions of whole slots: the first so many
// of every cell, then the next ones. However full the cells are, all lanes work.
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
        most_at_once_(static_cast<std::uint32_t>(16 * cells_ + 64)),
        slot_size_(
            static_cast<std::size_t>((plan.dimension() + 1 + plan.components) * lanes.lanes)),
        end_(static_cast<std::size_t>(cells_)),
        taken_(static_cast<std::size_t>(cells_)),
        begin_(static_cast<std::size_t>(lanes.groups) + 1) {
    for (const auto& field : particles.fields)
      for (int c = 0; c < field.components(); ++c)
        columns_.push_back({static_cast<const std::byte*>(field.first(c)), field.point_stride()});
  }

  void start(std::int64_t j, std::int64_t k) {
    row_ = {first_, j, k};
    sort(bins_.row(first_, first_ + cells_, j, k));
    slots_taken_ = 0;
  }

  // The next portion; false where there is none.
  bool next() {
    if (!more()) return false;
    const std::uint32_t slots = choose_slots();
    count_slots(slots);
    fill_slots();
    slots_taken_ += slots;
    return true;
  }

  // Does another portion follow?
  bool more() const { return slots_taken_ < fullest_; }

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
  static constexpr std::uint32_t slots_at_least = 16;

  // Sorts the particles by their cells, those of a cell in the order in which they come.
  void sort(std::span<const std::uint32_t> particles) {
    const GridAxis axis = plan_.axes[0];
    const auto cells = static_cast<std::uint32_t>(cells_);
    cell_of_.resize(particles.size());
    std::fill(end_.begin(), end_.end(), 0u);
    for (std::size_t i = 0; i < particles.size(); ++i) {
      const std::int64_t cell =
          axis.cell(static_cast<double>(particles_.points(particles[i], 0))) - first_;
      cell_of_[i] = cell >= 0 && cell < cells_ ? static_cast<std::uint32_t>(cell) : cells;
      if (cell_of_[i] < cells) ++end_[cell_of_[i]];
    }
    fullest_ = 0;
    std::uint32_t place = 0;
    for (std::uint32_t cell = 0; cell < cells; ++cell) {
      fullest_ = std::max(fullest_, end_[cell]);
      taken_[cell] = place;
      place += std::exchange(end_[cell], place);
    }
    sorted_.resize(place);
    for (std::size_t i = 0; i < particles.size(); ++i)
      if (cell_of_[i] < cells) sorted_[end_[cell_of_[i]]++] = particles[i];
  }

  // How many slots the next portion has: more than a few where the cells are not equally full, so
  // that one full cell does not make many small portions.
  std::uint32_t choose_slots() const {
    std::uint32_t slots = slots_at_least;
    for (; slots_taken_ + slots < fullest_; slots *= 2) {
      std::uint32_t count = 0;
      for (std::size_t cell = 0; cell < end_.size(); ++cell)
        count += std::min(end_[cell] - taken_[cell], 2 * slots);
      if (count > most_at_once_) break;
    }
    return slots;
  }

  // Chooses the particles of the portion, and finds the slots that each group needs: as many as its
  // fullest lane has particles. Also prefetches the data of the particles.
  void count_slots(std::uint32_t slots) {
    const auto groups = static_cast<std::size_t>(lanes_.groups);
    std::fill(begin_.begin(), begin_.end(), 0u);
    std::size_t number = 0;
    for (std::size_t cell = 0; cell < end_.size(); ++cell) {
      const std::uint32_t count = std::min(end_[cell] - taken_[cell], slots);
      std::uint32_t& most = begin_[cell % groups + 1];
      most = std::max(most, count);
      number += count;
    }
    for (std::size_t g = 0; g < groups; ++g) begin_[g + 1] += begin_[g];
    particle_.resize(number);
    cell_.resize(number);
    at_.resize(number);
    std::size_t i = 0;
    for (std::size_t cell = 0; cell < end_.size(); ++cell) {
      const std::uint32_t count = std::min(end_[cell] - taken_[cell], slots);
      std::size_t at = begin_[cell % groups] * slot_size_ + cell / groups;
      for (std::uint32_t s = 0; s < count; ++s, ++i, at += slot_size_) {
        particle_[i] = sorted_[taken_[cell]++];
        cell_[i] = static_cast<std::int64_t>(cell);
        at_[i] = at;
        for (const Column& column : columns_) __builtin_prefetch(column.at(particle_[i]));
      }
    }
  }

  void fill_slots() {
    slots_.reset(begin_.back() * slot_size_);
    const std::size_t count = particle_.size();
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
  std::uint32_t most_at_once_;  // particles
  std::size_t slot_size_;
  std::vector<Column> columns_;
  std::array<std::int64_t, max_dimension> row_{};  // the first cell
  // The particles of the row by cells: the place behind the last one of each cell, and that of the
  // next one to be taken; the number of particles of the fullest cell.
  std::vector<std::uint32_t> cell_of_, sorted_, end_, taken_;
  std::uint32_t fullest_ = 0, slots_taken_ = 0;
  // The particles of the portion: their cells, from first_, and where their numbers go.
  std::vector<std::uint32_t> particle_;
  std::vector<std::int64_t> cell_;
  std::vector<std::size_t> at_;
  std::vector<std::uint32_t> begin_;
  AlignedArray<Scalar> slots_;
};

}  // namespace recon
