// Everything within a radius of one target after another, in no order, by the kernels of
// cell_kernel.hpp; in periodic domains over all images.
#pragma once

#include "neighbourhood/shared_by_targets.hpp"
#include "recon/neighbourhood/periodic_images.hpp"

namespace recon::detail {

// A neighbour in one number: its index, and behind it the shift in periodic domains, so that the
// order of the keys is the one that the rules ask for.
template <bool periodic>
struct NeighbourKey {
  using Key = std::conditional_t<periodic, std::uint64_t, std::uint32_t>;

  static Key of(ParticleIndex index, const ImageShift& shift) {
    if constexpr (periodic) return with_code(index, code(shift));
    return index;
  }
  static Key with_code(ParticleIndex index, std::uint32_t shift_code) {
    return static_cast<Key>(index) << 24 | shift_code;
  }
  static std::uint32_t code(const ImageShift& shift) {
    std::uint32_t code = 0;
    for (const std::int8_t s : shift) code = code << 8 | static_cast<std::uint32_t>(s + 128);
    return code;
  }

  static ParticleIndex index(Key key) {
    if constexpr (periodic) return static_cast<ParticleIndex>(key >> 24);
    return static_cast<ParticleIndex>(key);
  }
  static ImageShift shift(Key key) {
    ImageShift shift{};
    for (int d = 0; d < max_dimension; ++d)
      shift[d] = static_cast<std::int8_t>(static_cast<int>(key >> (16 - 8 * d) & 0xFF) - 128);
    return shift;
  }
};

template <class S, int D, bool periodic>
class CellGather {
 public:
  using Point = std::array<S, D>;
  using Coding = NeighbourKey<periodic>;
  using Key = typename Coding::Key;

  CellGather(const SharedByTargets<S, D>& shared, CellBuffers<S, D, Key>& buffers)
      : shared_(shared),
        images_(buffers.images),
        distance2_(buffers.distance2),
        index_(buffers.index),
        shift_(buffers.shift) {
    images_.begin(shared.domain, shared.particles.box());
    // For the k nearest, particles found beyond k must be sorted out: they cost extra. For a
    // radius, what is found is the result, and does not count as wasted work.
    out_.work_per_found = shared.question.nearest ? 12 : -16;
    make_room(
        std::max<std::size_t>(512, distance2_.size() > beyond ? distance2_.size() - beyond : 0));
  }

  // The next target. The limit is for all calls of within() until the one after it.
  void start(const Point& x, std::int64_t work_limit) {
    x_ = x;
    out_.work = 0;
    out_.work_limit = work_limit;
  }
  const Point& x() const { return x_; }
  std::int64_t work() const { return out_.work + out_.work_per_found * out_.count; }

  // False if it was too much work.
  bool within(S radius) {
    out_.count = 0;
    if constexpr (!periodic) return add_image(x_, radius);
    if (!images_needed(radius)) return add_image(x_, radius) && put_shift(0, {});
    // The shape of a cube reaches to its corners.
    const bool cube = shared_.options.shape == SupportShape::cube && !shared_.question.nearest;
    const S limit =
        cube ? std::min(reach(radius * std::sqrt(S(D))), std::numeric_limits<S>::max()) : radius;
    typename PeriodicImages<S, D>::Image image;
    for (images_.start(x_); images_.next(limit * limit, image);) {
      const std::int64_t before = out_.count;
      if (!add_image(image.x, radius)) return false;
      put_shift(before, image.shift);
    }
    return true;
  }

  // What the latest call of within() found. The arrays are longer by what the kernels may touch.
  std::size_t count() const { return static_cast<std::size_t>(out_.count); }
  S* distance2() { return out_.distance2; }
  std::uint32_t* index() { return out_.index; }
  Key key(std::size_t i) const {
    if constexpr (periodic) return Coding::with_code(index_[i], shift_[i]);
    return index_[i];
  }

 private:
  void make_room(std::size_t count) {
    out_.capacity = static_cast<std::int64_t>(count);
    distance2_.resize(count + beyond);
    index_.resize(count + beyond);
    if constexpr (periodic) shift_.resize(count + beyond);
    out_.distance2 = distance2_.data();
    out_.index = index_.data();
  }

  bool add_image(const Point& x, S radius) {
    const std::int64_t count = out_.count, work = out_.work;
    for (;;) {
      const GatherResult result =
          shared_.kernels.gather(shared_.grid->sorted_cells().view(), x.data(), radius, out_);
      if (result != GatherResult::no_room) return result == GatherResult::complete;
      make_room(4 * static_cast<std::size_t>(out_.capacity));
      out_.count = count;
      out_.work = work;
    }
  }

  bool put_shift(std::int64_t from, const ImageShift& shift) {
    std::fill(shift_.data() + from, shift_.data() + out_.count, Coding::code(shift));
    return true;
  }

  // May an image other than the target itself be within the radius of a particle?
  bool images_needed(S radius) const {
    const S far = reach(radius);
    const auto& box = shared_.particles.box();
    for (int d = 0; d < D; ++d) {
      if (!shared_.domain.periodic[d]) continue;
      const S period = shared_.domain.period(d);
      if (!(box.lower[d] - (x_[d] - period) > far) || !(x_[d] + period - box.upper[d] > far))
        return true;
    }
    return false;
  }

  static constexpr std::size_t beyond = 64;  // what the kernels may touch behind the last

  const SharedByTargets<S, D>& shared_;
  PeriodicImages<S, D>& images_;
  Point x_{};
  Gathered<S> out_{nullptr, nullptr};
  std::vector<S>& distance2_;
  std::vector<std::uint32_t>&index_, &shift_;
};

}  // namespace recon::detail
