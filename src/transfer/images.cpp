#include "recon/transfer/images.hpp"

#include <cmath>

namespace recon {
namespace {

using detail::require;

// Every image belongs to one of so many entries.
template <int D>
void require_entries(std::size_t entries, const std::vector<Image<D>>& images) {
  for (const Image<D>& image : images)
    require(image.of < entries, "number of the particle of an image", image.of,
            "must be that of an entry");
}

}  // namespace

template <int D>
Images<D>::Images(const CartesianGrid<D>& grid, double reach)
    : lower_(grid.lower()), reach_(reach) {
  if (grid.size() == 0) detail::throw_no_cells();
  require(reach > 0 && std::isfinite(reach), "reach of images", reach,
          "must be positive and finite");
  for (int d = 0; d < D; ++d) upper_[d] = grid.upper(d);
}

template <int D>
void Images<D>::mirror(int axis, bool upper) {
  require(axis >= 0 && axis < D, "axis of a mirror", axis, "must be an axis of the grid");
  mirror(axis, upper, (upper ? upper_ : lower_)[axis], Mirror::even);
}

template <int D>
void Images<D>::mirror(int axis, bool upper, double at, Mirror kind) {
  require(axis >= 0 && axis < D, "axis of a mirror", axis, "must be an axis of the grid");
  require(std::isfinite(at), "place of a mirror", at, "must be finite");
  require(!repeats_[axis], "axis of a mirror", axis, "must not repeat itself");
  require(upper ? at > lower_[axis] : at < upper_[axis], "place of a mirror", at,
          "must leave room to the other end of its axis");
  mirrors_[axis][upper] = kind;
  (upper ? upper_ : lower_)[axis] = at;
  const auto reversed = [&](bool end) {
    return *mirrors_[axis][end] == Mirror::even ? vector_parity(axis) : (1u << D) - 1;
  };
  std::vector<Along>& along = along_[axis];
  along.clear();
  if (mirrors_[axis][0] && mirrors_[axis][1]) {  // two mirrors: a translation by twice the edge
    const double period = 2 * (upper_[axis] - lower_[axis]);
    const int most = static_cast<int>(std::ceil((reach_ + period) / period));
    for (int n = -most; n <= most; ++n) {
      const unsigned turned = n % 2 == 0 ? 0 : reversed(false) ^ reversed(true);
      along.push_back({-1, 2 * lower_[axis] + n * period, reversed(false) ^ turned});
      if (n != 0) along.push_back({1, n * period, turned});
    }
  } else {
    along.push_back({-1, 2 * at, reversed(upper)});
  }
}

template <int D>
void Images<D>::repeat(int axis, double lower, double upper) {
  require(axis >= 0 && axis < D, "axis of a period", axis, "must be an axis of the grid");
  require(std::isfinite(lower) && std::isfinite(upper) && lower < upper, "end of a period", upper,
          "must be finite and above its beginning");
  require(!mirrors_[axis][0] && !mirrors_[axis][1], "axis of a period", axis,
          "must have no mirrors");
  repeats_[axis] = true;
  lower_[axis] = lower;
  upper_[axis] = upper;
  const double period = upper - lower;
  const int most = static_cast<int>(std::ceil(reach_ / period)) + 1;
  along_[axis].clear();
  for (int n = -most; n <= most; ++n)
    if (n != 0) along_[axis].push_back({1, n * period, 0});
}

template <int D>
bool Images<D>::empty() const {
  for (const auto& along : along_)
    if (!along.empty()) return false;
  return true;
}

template <int D>
std::vector<Image<D>> Images<D>::of(const std::vector<SpaceVector<D>>& places) const {
  std::vector<Image<D>> images;
  std::vector<Image<D>> of_one;
  for (std::size_t p = 0; p < places.size(); ++p) {
    const SpaceVector<D>& x = places[p];
    if (!x.allFinite()) [[unlikely]]
      detail::throw_invalid("place of particle " + std::to_string(p), x.transpose(),
                            "must be finite");
    of_one.assign(1, {static_cast<std::uint32_t>(p), 0, 0, x});
    for (int d = 0; d < D; ++d) {
      const std::size_t before = of_one.size();  // all of which have images along this axis
      for (const Along& to : along_[d]) {
        const double place = to.sign * x[d] + to.shift;
        if (place < lower_[d] - reach_ || place > upper_[d] + reach_) continue;
        for (std::size_t i = 0; i < before; ++i) {
          Image<D> image = of_one[i];
          image.x[d] = place;
          if (to.sign < 0) image.mirrored |= 1u << d;
          image.reversed ^= to.reversed;
          of_one.push_back(image);
        }
      }
    }
    images.insert(images.end(), of_one.begin() + 1, of_one.end());
  }
  return images;
}

template <int D>
std::vector<SpaceVector<D>> with_places(const std::vector<SpaceVector<D>>& places,
                                        const std::vector<Image<D>>& images) {
  require_entries(places.size(), images);
  std::vector<SpaceVector<D>> all = places;
  all.reserve(places.size() + images.size());
  for (const Image<D>& image : images) all.push_back(image.x);
  return all;
}

template <int D>
std::vector<SpaceVector<D>> with_vectors(const std::vector<SpaceVector<D>>& vectors,
                                         const std::vector<Image<D>>& images) {
  require_entries(vectors.size(), images);
  std::vector<SpaceVector<D>> all = vectors;
  all.reserve(vectors.size() + images.size());
  for (const Image<D>& image : images) all.push_back(image.vector(vectors[image.of]));
  return all;
}

template <int D>
void append_rows(RowsOfParticles& rows, const std::vector<Image<D>>& images,
                 std::span<const Parity> parities) {
  const auto columns = static_cast<std::size_t>(rows.cols());
  require(parities.size() == columns, "parities", parities.size(), "must be one for each column");
  const Eigen::Index count = rows.rows();
  require_entries(static_cast<std::size_t>(count), images);
  rows.conservativeResize(count + static_cast<Eigen::Index>(images.size()), Eigen::NoChange);
  for (std::size_t i = 0; i < images.size(); ++i)
    for (std::size_t c = 0; c < columns; ++c) {
      const auto column = static_cast<Eigen::Index>(c);
      rows(count + static_cast<Eigen::Index>(i), column) =
          mirror_sign(parities[c], images[i].mirrored) *
          rows(static_cast<Eigen::Index>(images[i].of), column);
    }
}

#define RECON_INSTANTIATE(D)                                                            \
  template class Images<D>;                                                             \
  template std::vector<SpaceVector<D>> with_places(const std::vector<SpaceVector<D>>&,  \
                                                   const std::vector<Image<D>>&);       \
  template std::vector<SpaceVector<D>> with_vectors(const std::vector<SpaceVector<D>>&, \
                                                    const std::vector<Image<D>>&);      \
  template void append_rows(RowsOfParticles&, const std::vector<Image<D>>&,             \
                            std::span<const Parity>);
RECON_INSTANTIATE(1)
RECON_INSTANTIATE(2)
RECON_INSTANTIATE(3)
#undef RECON_INSTANTIATE

}  // namespace recon
