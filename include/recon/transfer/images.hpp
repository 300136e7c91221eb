// Images of particles beyond planes of symmetry, fixed walls and the ends of periods: what sums and
// fits near them are to see, so that they are as good there as inside.
//
// In a mirror at x_d = a the place x_d becomes 2 a - x_d, and every quantity keeps its value or
// changes its sign. A set of axes, one bit for each, says which: a vector component changes its
// sign where its own axis is mirrored, sigma_rc where just one of the axes r and c is, a scalar
// never. In an odd mirror, which is a wall that holds what it touches, a vector changes the signs of
// all its components: u(2 a - x_d) = -u(x_d), so that u is zero on the plane. Along a period P the
// place x_d becomes x_d + n P, and nothing changes. Beyond two planes of different axes there are
// images of images, in the corner; between two planes of one axis there are as many as the reach has
// room for.
//
// ```cpp
//   const recon::CartesianGrid<2> grid({0, 0}, {1, 1}, h);
//   recon::Images<2> images(grid, 2 * h);  // as far as the support of a fit
//   images.mirror(0, false);               // at the lower face across x
//   const std::vector<recon::SpaceVector<2>> places(5, {0.01, 0.4}), velocities(5, {1, 2});
//   const auto seen = images.of(places);
//   const auto all_places = recon::with_places(places, seen);         // 5 at x = -0.01 after them
//   const auto all_velocities = recon::with_vectors(velocities, seen);  // these have (-1, 2)
// ```
//
// Images follow the particles, in their order: the same bits for any number of threads.
#pragma once

#include <bit>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "recon/transfer/cartesian_grid.hpp"

namespace recon {

// The axes, one bit for each, whose mirrors change the sign of a quantity: of a scalar, of the
// component d of a vector, of the component (r, c) of a tensor.
using Parity = unsigned;
inline constexpr Parity scalar_parity = 0;
constexpr Parity vector_parity(int d) {
  return 1u << d;
}
constexpr Parity tensor_parity(int r, int c) {
  return vector_parity(r) ^ vector_parity(c);
}
// 1 or -1: what a quantity is multiplied by where these axes are mirrored.
constexpr double mirror_sign(Parity parity, unsigned mirrored) {
  return std::popcount(parity & mirrored) % 2 == 0 ? 1 : -1;
}

// Whether a mirror changes the sign of a vector's component along its axis, or of all.
enum class Mirror { even, odd };

// An image of particle number `of`, mirrored along the axes whose bits are set in `mirrored`, with
// the components of vectors reversed whose bits are set in `reversed`. In even mirrors both are the
// same.
template <int D>
struct Image {
  std::uint32_t of = 0;
  unsigned mirrored = 0, reversed = 0;
  SpaceVector<D> x;

  // The signs of the axes in these bits.
  static SpaceVector<D> signs(unsigned bits) {
    SpaceVector<D> sign;
    for (int d = 0; d < D; ++d) sign[d] = mirror_sign(vector_parity(d), bits);
    return sign;
  }
  // What a vector from one place to another becomes, and what a velocity or force does.
  SpaceVector<D> offset(const SpaceVector<D>& r) const { return signs(mirrored).cwiseProduct(r); }
  SpaceVector<D> vector(const SpaceVector<D>& v) const { return signs(reversed).cwiseProduct(v); }
  // And the gradient of a velocity, or the stress, which takes places to forces.
  Eigen::Matrix<double, D, D> gradient(const Eigen::Matrix<double, D, D>& L) const {
    return signs(reversed).asDiagonal() * L * signs(mirrored).asDiagonal();
  }
};

template <int D>
class Images {
 public:
  // Images at most `reach` beyond the planes of mirrors, the ends of periods and, on other axes,
  // the box of the grid. Throws InvalidArgument unless the reach is positive and finite, and for a
  // grid without cells.
  Images(const CartesianGrid<D>& grid, double reach);

  // The lower or the upper face across an axis is a plane of symmetry. Throws InvalidArgument for
  // an axis that the grid does not have.
  void mirror(int axis, bool upper);
  // A mirror anywhere, below or above the particles. Throws InvalidArgument also for a place that
  // is not finite, planes of an axis in the wrong order, and an axis that repeats itself.
  void mirror(int axis, bool upper, double at, Mirror kind);
  // What lies from `lower` to `upper` along an axis repeats itself. Throws InvalidArgument unless
  // both are finite and in this order, and for an axis with mirrors.
  void repeat(int axis, double lower, double upper);
  // Whether there is neither a plane nor a period.
  bool empty() const;

  // The images of all places, those of one particle consecutive. Throws InvalidArgument for places
  // that are not finite, naming the particle.
  std::vector<Image<D>> of(const std::vector<SpaceVector<D>>& places) const;

 private:
  // The places of one axis, x -> sign x + shift, and which components of vectors are reversed.
  struct Along {
    double sign = 1, shift = 0;
    unsigned reversed = 0;
  };
  std::array<std::vector<Along>, D> along_;  // without the place itself
  std::array<std::array<std::optional<Mirror>, 2>, D> mirrors_{};
  std::array<bool, D> repeats_{};
  SpaceVector<D> lower_, upper_;
  double reach_;
};

// What was given, and after it what the images have. Throw InvalidArgument unless there is an entry
// for each particle that has images, and for rows one parity for each column.
template <int D>
std::vector<SpaceVector<D>> with_places(const std::vector<SpaceVector<D>>& places,
                                        const std::vector<Image<D>>& images);
template <int D>
std::vector<SpaceVector<D>> with_vectors(const std::vector<SpaceVector<D>>& vectors,
                                         const std::vector<Image<D>>& images);
using RowsOfParticles = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
template <int D>
void append_rows(RowsOfParticles& rows, const std::vector<Image<D>>& images,
                 std::span<const Parity> parities);

extern template class Images<1>;
extern template class Images<2>;
extern template class Images<3>;

}  // namespace recon
