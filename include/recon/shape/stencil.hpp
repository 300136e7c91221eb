// From neighbours to a local problem: scaled offsets, weights and their slopes for one target.
//
//     xi = (x_p - x) / rho,   radial: w = w(|xi|),   tensor product: w = prod_d w(|xi_d|),
//     d w / d x = -(sum_d dw/dxi_d (e_d + xi_d grad rho)) / rho .
// Where a pair has a support rho_p of its own, w is that of |xi| rho / rho_p. Where its support is
// an ellipsoid of its own, the caller says q and q dq / dxi. With particle weights m_p, w and its
// derivatives are multiplied by them. Weights are divided by the largest, so that a fit does not
// see their scale. The arrays are kept from target to target (core/memory.hpp): nothing is
// allocated once warm. Use one object per thread.
//
// T may be a pack (core/pack.hpp), with one target in each lane: then particles are not dropped but
// get the weight 0.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "recon/core/error.hpp"
#include "recon/core/lanes.hpp"
#include "recon/core/memory.hpp"
#include "recon/local_solve/local_cloud.hpp"
#include "recon/weights/weight.hpp"

namespace recon {

template <class T, int D, class Memory = Growing>
class Stencil {
  static constexpr std::size_t each = 5 * D + 3;  // numbers for every neighbour

 public:
  using Scalar = ScalarOf<T>;
  static constexpr int lanes = LaneTraits<T>::lanes;

  // What is taken from a Workspace for this many neighbours.
  static constexpr std::size_t bytes_for(int most) {
    const auto count = static_cast<std::size_t>(most);
    return Workspace::bytes_for<T>(each * count) + Workspace::bytes_for<int>(count);
  }

  constexpr explicit Stencil(Memory memory = {})
      : numbers_(memory.template make<T, 0, each>()), place_(memory.template make<int, 0, 1>()) {}

  // Begins a target at x with support rho > 0 and this many neighbours; in a pack, `present` says
  // how many of them each lane has.
  constexpr void start(const std::array<T, D>& x, const T& rho, int count) {
    start(x, rho, count, T(count));
  }
  constexpr void start(const std::array<T, D>& x, const T& rho, int count, const T& present) {
    using std::abs;
    count_ = count;
    present_ = present;
    rho_ = rho;
    T size = T(0);
    for (int d = 0; d < D; ++d) size = detail::larger(T(abs(x[d])), size);
    noise_ = T(std::numeric_limits<Scalar>::epsilon()) * (size + rho) / rho;
    weighs_particles_ = has_pair_supports_ = has_pair_distances_ = false;
    detail::provide(numbers_, each * static_cast<std::size_t>(count));
    if constexpr (lanes == 1) detail::provide(place_, static_cast<std::size_t>(count));
  }

  // The caller fills in x_p - x along axis d, a length: that of neighbour p in lane l at [p * lanes
  // + l], and 0 for neighbours that a lane does not have.
  constexpr Scalar* offsets(int d) { return lane_by_lane(xi(d)); }

  // The caller fills in the particle weights m_p >= 0, laid out as offsets(). Called only where
  // particles have weights of their own, and before weigh().
  constexpr Scalar* particle_weights() {
    weighs_particles_ = true;
    return lane_by_lane(particle_weight());
  }

  // The caller fills in the supports rho_p > 0 of the pairs, laid out as offsets(), and any
  // positive number for neighbours that a lane does not have. Called only where pairs have supports
  // of their own, and before weigh().
  constexpr Scalar* pair_supports() {
    has_pair_supports_ = true;
    return lane_by_lane(pair_ratio());
  }

  // The caller fills in q >= 0 of the pairs, laid out as offsets(), and any number for neighbours
  // that a lane does not have. Called only for radial weights where pairs have ellipsoids of their
  // own as supports, and before weigh(). Where that is to form slopes, the caller also fills in
  // q dq / dxi along each axis d.
  constexpr Scalar* pair_distances() {
    has_pair_distances_ = true;
    return lane_by_lane(pair_ratio());
  }
  constexpr Scalar* pair_slopes(int d) { return lane_by_lane(factor(d)); }

  // Evaluates the weights, with `slopes` their derivatives too, and drops the particles whose
  // weight is not above eps^2 of the largest: those change nothing in working precision.
  // weights.evaluate(q, w, slope, n) takes arrays of T. support_factor is that of NeighbourList.
  template <class Weights>
  constexpr void weigh(const Weights& weights, WeightForm form, bool slopes,
                       Scalar support_factor = Scalar(0)) {
    const int n = count_;
    T* const offset = xi(0);  // of all axes
    if constexpr (lanes == 1) {
      for (int i = 0; i < D * n; ++i) offset[i] /= rho_;
    } else {
      const T inverse = T(1) / rho_;
      for (int i = 0; i < D * n; ++i) offset[i] *= inverse;
    }
    T* const ratio = pair_ratio();
    for (int p = 0; has_pair_supports_ && p < n; ++p) ratio[p] = rho_ / ratio[p];
    evaluate_weights(weights, form, slopes);
    if (slopes) differentiate(form, support_factor);
    if (weighs_particles_) multiply_by_particle_weights(slopes);
    compact(slopes);
  }

  constexpr LocalCloud<T, D> cloud() const {
    LocalCloud<T, D> cloud;
    cloud.size = size_;
    cloud.rho = rho_;
    cloud.noise = noise_;
    cloud.w = array(3 * D);
    for (int d = 0; d < D; ++d) {
      cloud.xi[d] = array(d);
      cloud.dw[d] = array(D + d);
    }
    return cloud;
  }

  // The position of particle p of the cloud in the target's row of the neighbour list. Not for
  // packs, which keep all particles.
  constexpr int place(int p) const { return place_[p]; }
  // The number of particles with a weight.
  constexpr const T& weighted() const { return weighted_; }

 private:
  // Arrays of count_ numbers, one for each axis where they take a d.
  constexpr T* array(int i) { return numbers_.data() + static_cast<std::size_t>(i) * count_; }
  constexpr const T* array(int i) const {
    return numbers_.data() + static_cast<std::size_t>(i) * count_;
  }
  constexpr T* xi(int d) { return array(d); }
  constexpr T* dw(int d) { return array(D + d); }
  constexpr T* q(int d) { return array(2 * D + d); }
  constexpr T* w() { return array(3 * D); }
  constexpr T* particle_weight() { return array(3 * D + 1); }
  constexpr T* pair_ratio() { return array(3 * D + 2); }
  constexpr T* factor(int d) { return array(3 * D + 3 + d); }
  constexpr T* slope(int d) { return array(4 * D + 3 + d); }

  static constexpr Scalar* lane_by_lane(T* numbers) {
    if constexpr (std::is_same_v<T, Scalar>)
      return numbers;
    else
      return reinterpret_cast<Scalar*>(numbers);
  }

  // Sets w and, with slopes, dw = d w / d xi. Radial: one factor of q = |xi|; tensor product: a
  // factor per axis.
  template <class Weights>
  constexpr void evaluate_weights(const Weights& weights, WeightForm form, bool slopes) {
    const int n = count_;
    using std::abs;
    const std::array<T*, D> x = per_axis(0), derivative = per_axis(D);
    T *const product = w(), *const ratio = pair_ratio();
    if (form == WeightForm::radial) {
      T *const distance = q(0), *const tangent = slope(0);
      for (int p = 0; has_pair_distances_ && p < n; ++p) distance[p] = within_support(p, ratio[p]);
      for (int p = 0; !has_pair_distances_ && p < n; ++p) {
        T q2 = x[0][p] * x[0][p];
        for (int d = 1; d < D; ++d) q2 += x[d][p] * x[d][p];
        distance[p] = within_support(p, detail::square_root(q2));
      }
      stretch(distance);
      weights.evaluate(distance, product, slopes ? tangent : nullptr, n);
      const std::array<T*, D> outwards = has_pair_distances_ ? per_axis(3 * D + 3) : x;
      for (int p = 0; slopes && p < n; ++p) {
        const auto apart = distance[p] > T(0);
        T along = tangent[p] / detail::select(apart, distance[p], T(1));
        if (has_pair_supports_) along *= ratio[p] * ratio[p];
        for (int d = 0; d < D; ++d)
          derivative[d][p] = detail::select(apart, T(along * outwards[d][p]), T(0));
      }
    } else {
      const std::array<T*, D> factors = per_axis(3 * D + 3);
      for (int d = 0; d < D; ++d) {
        T* const distance = q(d);
        for (int p = 0; p < n; ++p) distance[p] = within_support(p, T(abs(x[d][p])));
        stretch(distance);
        weights.evaluate(distance, factors[d], slopes ? slope(d) : nullptr, n);
      }
      for (int p = 0; p < n; ++p) {
        T all = factors[0][p];
        for (int d = 1; d < D; ++d) all *= factors[d][p];
        product[p] = all;
      }
      for (int d = 0; slopes && d < D; ++d) {
        const T* const tangent = slope(d);
        for (int p = 0; p < n; ++p) {
          T others = tangent[p];
          if (has_pair_supports_) others *= ratio[p];
          for (int e = 0; e < D; ++e)
            if (e != d) others *= factors[e][p];
          derivative[d][p] = sign(x[d][p]) * others;
        }
      }
    }
  }

  constexpr std::array<T*, D> per_axis(int first) {
    std::array<T*, D> arrays{};
    for (int d = 0; d < D; ++d) arrays[d] = array(first + d);
    return arrays;
  }

  // From distances in units of rho to those in units of the pairs' supports.
  constexpr void stretch(T* distance) {
    const int n = count_;
    const T* const ratio = pair_ratio();
    for (int p = 0; has_pair_supports_ && p < n; ++p)
      distance[p] =
          within_support(p, detail::select(distance[p] > T(0), T(distance[p] * ratio[p]), T(0)));
  }

  // q; but 1 for particles that a lane does not have: they get weight 0 and are never
  // passed to the weight.
  constexpr T within_support(int p, const T& distance) const {
    if constexpr (lanes > 1)
      return detail::select(T(p) < present_, distance, T(1));
    else
      return distance;
  }

  // Multiplies by m_p relative to the largest m_p among the particles that count: the product
  // stays in range.
  constexpr void multiply_by_particle_weights(bool slopes) {
    const int n = count_;
    T *const product = w(), *const mass = particle_weight();
    const std::array<T*, D> derivative = per_axis(D);
    T largest = T(0);
    for (int p = 0; p < n; ++p)
      largest = detail::larger(detail::select(product[p] > T(0), mass[p], T(0)), largest);
    const T inverse = T(1) / detail::select(largest > T(0), largest, T(1));
    for (int p = 0; p < n; ++p) {
      const T ratio = detail::select(product[p] > T(0), T(mass[p] * inverse), T(0));
      product[p] *= ratio;
      for (int d = 0; slopes && d < D; ++d) derivative[d][p] *= ratio;
    }
  }

  // The sign of a number: -1, 0 or 1.
  static constexpr T sign(const T& x) {
    return detail::select(x > T(0), T(1), detail::select(x < T(0), T(-1), T(0)));
  }

  // Turns dw into d w / d x: xi = (x_p - x) / rho gives d xi_d = -(e_d + xi_d grad rho) / rho.
  constexpr void differentiate(WeightForm form, Scalar support_factor) {
    const int n = count_;
    const std::array<T, D> grow = support_gradient(form, support_factor);
    const std::array<T*, D> x = per_axis(0), derivative = per_axis(D);
    for (int p = 0; p < n; ++p) {
      T along = T(0);
      for (int d = 0; d < D; ++d) along += derivative[d][p] * x[d][p];
      for (int d = 0; d < D; ++d) derivative[d][p] = -(derivative[d][p] + along * grow[d]) / rho_;
    }
  }

  // The gradient of rho = support_factor * distance to the farthest neighbour; 0 for supports
  // that stand still.
  constexpr std::array<T, D> support_gradient(WeightForm form, Scalar support_factor) {
    const int n = count_;
    using std::abs;
    const std::array<T*, D> x = per_axis(0), distances = per_axis(2 * D);
    std::array<T, D> gradient{};
    if (!(support_factor > Scalar(0))) return gradient;
    const T factor = T(support_factor);
    T distance = T(0);
    for (int p = 0; p < n; ++p)
      for (int d = 0; d < (form == WeightForm::radial ? 1 : D); ++d) {
        auto farther = distances[d][p] > distance;
        if constexpr (lanes > 1) farther = farther && T(p) < present_;
        if (!detail::any_lane(farther)) continue;
        distance = detail::select(farther, distances[d][p], distance);
        for (int e = 0; e < D; ++e) {
          const T direction = form == WeightForm::radial
                                  ? T(x[e][p] / detail::select(farther, distances[d][p], T(1)))
                              : e == d ? sign(x[e][p])
                                       : T(0);
          gradient[e] = detail::select(farther, T(-factor * direction), gradient[e]);
        }
      }
    // Where all neighbours coincide with the target, the support was chosen in another way
    // and stands still.
    const auto moves =
        distance > T(0) && T(abs(distance * factor - T(1))) <= detail::constant<T>(1e-3);
    for (T& g : gradient) g = detail::select(moves, g, T(0));
    return gradient;
  }

  constexpr void compact(bool slopes) {
    const int n = count_;
    T* const product = w();
    const std::array<T*, D> x = per_axis(0), derivative = per_axis(D);
    T largest = T(0);
    for (int p = 0; p < n; ++p) largest = detail::larger(product[p], largest);
    auto usable = largest >= T(std::numeric_limits<Scalar>::min());
    if constexpr (lanes == 1) {
      detail::require(detail::is_finite(largest), "largest product of weights at a target", largest,
                      "must be finite");
    } else {
      usable = usable && largest <= T(std::numeric_limits<Scalar>::max());
    }
    const T inverse = T(1) / detail::select(usable, largest, T(1));
    const T least = largest * T(std::numeric_limits<Scalar>::epsilon() *
                                std::numeric_limits<Scalar>::epsilon());
    weighted_ = T(0);
    if constexpr (lanes > 1) {
      for (int p = 0; p < n; ++p) {
        const auto keep = usable && product[p] > least;
        product[p] = detail::select(keep, T(product[p] * inverse), T(0));
        weighted_ += detail::select(keep, T(1), T(0));
        for (int d = 0; slopes && d < D; ++d)
          derivative[d][p] = detail::select(keep, T(derivative[d][p] * inverse), T(0));
      }
      size_ = n;
    } else {
      size_ = 0;
      for (int p = 0; usable && p < n; ++p) {
        if (!(product[p] > least)) continue;
        for (int d = 0; d < D; ++d) {
          x[d][size_] = x[d][p];
          if (slopes) derivative[d][size_] = derivative[d][p] * inverse;
        }
        product[size_] = product[p] * inverse;
        place_[size_] = p;
        ++size_;
      }
      weighted_ = T(size_);
    }
  }

  int count_ = 0, size_ = 0;
  T present_ = T(0), weighted_ = T(0), rho_ = T(1), noise_ = T(0);
  bool weighs_particles_ = false, has_pair_supports_ = false, has_pair_distances_ = false;
  typename Memory::template Store<T, 0, each> numbers_;
  typename Memory::template Store<int, 0, 1> place_;  // of the `size_` particles of the cloud
};

}  // namespace recon
