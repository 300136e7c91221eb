// From neighbours to a local problem: scaled offsets, weights and their slopes for one target.
//
//     xi = (x_p - x) / rho,   radial: w = w(|xi|),   tensor product: w = prod_d w(|xi_d|),
//     d w / d x = -(sum_d dw/dxi_d (e_d + xi_d grad rho)) / rho .
// Where a pair has a support rho_p of its own, w is that of |xi| rho / rho_p.
// With particle weights m_p, w and its derivatives are multiplied by them. Weights are divided by
// the largest, so that a fit does not see their scale. The arrays are kept from target to target:
// nothing is allocated once warm. Use one object per thread.
//
// T may be a pack (core/pack.hpp), with one target in each lane: then particles are not dropped but
// get the weight 0.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "recon/core/error.hpp"
#include "recon/core/lanes.hpp"
#include "recon/local_solve/local_cloud.hpp"
#include "recon/weights/weight.hpp"

namespace recon {

template <class T, int D>
class Stencil {
 public:
  using Scalar = ScalarOf<T>;
  static constexpr int lanes = LaneTraits<T>::lanes;

  // Begins a target at x with support rho > 0 and this many neighbours; in a pack, `present` says
  // how many of them each lane has.
  void start(const std::array<T, D>& x, const T& rho, int count) { start(x, rho, count, T(count)); }
  void start(const std::array<T, D>& x, const T& rho, int count, const T& present) {
    using std::abs;
    count_ = count;
    present_ = present;
    rho_ = rho;
    T size = T(0);
    for (int d = 0; d < D; ++d) size = detail::larger(T(abs(x[d])), size);
    noise_ = T(std::numeric_limits<Scalar>::epsilon()) * (size + rho) / rho;
    w_.resize(count);
    weighs_particles_ = has_pair_supports_ = false;
    for (int d = 0; d < D; ++d)
      for (auto* array : {&xi_[d], &q_[d], &factor_[d], &slope_[d], &dw_[d]}) array->resize(count);
  }

  // The caller fills in x_p - x along axis d, a length: that of neighbour p in lane l at [p * lanes
  // + l], and 0 for neighbours that a lane does not have.
  Scalar* offsets(int d) { return reinterpret_cast<Scalar*>(xi_[d].data()); }

  // The caller fills in the particle weights m_p >= 0, laid out as offsets(). Called only where
  // particles have weights of their own, and before weigh().
  Scalar* particle_weights() {
    weighs_particles_ = true;
    particle_weight_.resize(count_);
    return reinterpret_cast<Scalar*>(particle_weight_.data());
  }

  // The caller fills in the supports rho_p > 0 of the pairs, laid out as offsets(), and any positive
  // number for neighbours that a lane does not have. Called only where pairs have supports of their
  // own, and before weigh().
  Scalar* pair_supports() {
    has_pair_supports_ = true;
    pair_ratio_.resize(count_);
    return reinterpret_cast<Scalar*>(pair_ratio_.data());
  }

  // Evaluates the weights, with `slopes` their derivatives too, and drops the particles whose
  // weight is not above eps^2 of the largest: those change nothing in working precision.
  // weights.evaluate(q, w, slope, n) takes arrays of T. support_factor is that of NeighbourList.
  template <class Weights>
  void weigh(const Weights& weights, WeightForm form, bool slopes,
             Scalar support_factor = Scalar(0)) {
    if constexpr (lanes == 1) {
      for (int d = 0; d < D; ++d)
        for (T& offset : xi_[d]) offset /= rho_;
    } else {
      const T inverse = T(1) / rho_;
      for (int d = 0; d < D; ++d)
        for (T& offset : xi_[d]) offset *= inverse;
    }
    for (int p = 0; has_pair_supports_ && p < count_; ++p) pair_ratio_[p] = rho_ / pair_ratio_[p];
    evaluate_weights(weights, form, slopes);
    if (slopes) differentiate(form, support_factor);
    if (weighs_particles_) multiply_by_particle_weights(slopes);
    compact(slopes);
  }

  LocalCloud<T, D> cloud() const {
    LocalCloud<T, D> cloud;
    cloud.size = lanes == 1 ? static_cast<int>(place_.size()) : count_;
    cloud.rho = rho_;
    cloud.noise = noise_;
    cloud.w = w_.data();
    for (int d = 0; d < D; ++d) {
      cloud.xi[d] = xi_[d].data();
      cloud.dw[d] = dw_[d].data();
    }
    return cloud;
  }

  // The position of particle p of the cloud in the target's row of the neighbour list. Not for
  // packs, which keep all particles.
  int place(int p) const { return place_[p]; }
  // The number of particles with a weight.
  const T& weighted() const { return weighted_; }

 private:
  // Sets w_ and, with slopes, dw_ = d w / d xi. Radial: one factor of q = |xi|; tensor product: a
  // factor per axis.
  template <class Weights>
  void evaluate_weights(const Weights& weights, WeightForm form, bool slopes) {
    using std::abs, std::sqrt;
    if (form == WeightForm::radial) {
      for (int p = 0; p < count_; ++p) {
        T q2 = xi_[0][p] * xi_[0][p];
        for (int d = 1; d < D; ++d) q2 += xi_[d][p] * xi_[d][p];
        q_[0][p] = within_support(p, T(sqrt(q2)));
      }
      stretch(q_[0]);
      weights.evaluate(q_[0].data(), w_.data(), slopes ? slope_[0].data() : nullptr, count_);
      for (int p = 0; slopes && p < count_; ++p) {
        const auto apart = q_[0][p] > T(0);
        T along = slope_[0][p] / detail::select(apart, q_[0][p], T(1));
        if (has_pair_supports_) along *= pair_ratio_[p] * pair_ratio_[p];
        for (int d = 0; d < D; ++d) dw_[d][p] = detail::select(apart, T(along * xi_[d][p]), T(0));
      }
    } else {
      for (int d = 0; d < D; ++d) {
        for (int p = 0; p < count_; ++p) q_[d][p] = within_support(p, T(abs(xi_[d][p])));
        stretch(q_[d]);
        weights.evaluate(q_[d].data(), factor_[d].data(), slopes ? slope_[d].data() : nullptr,
                         count_);
      }
      for (int p = 0; p < count_; ++p) {
        w_[p] = factor_[0][p];
        for (int d = 1; d < D; ++d) w_[p] *= factor_[d][p];
      }
      for (int d = 0; slopes && d < D; ++d)
        for (int p = 0; p < count_; ++p) {
          T others = slope_[d][p];
          if (has_pair_supports_) others *= pair_ratio_[p];
          for (int e = 0; e < D; ++e)
            if (e != d) others *= factor_[e][p];
          dw_[d][p] = sign(xi_[d][p]) * others;
        }
    }
  }

  // From distances in units of rho to those in units of the pairs' supports.
  void stretch(std::vector<T>& q) const {
    for (int p = 0; has_pair_supports_ && p < count_; ++p)
      q[p] = within_support(p, detail::select(q[p] > T(0), T(q[p] * pair_ratio_[p]), T(0)));
  }

  // q; but 1 for particles that a lane does not have: they get weight 0 and are never
  // passed to the weight.
  T within_support(int p, const T& q) const {
    if constexpr (lanes > 1)
      return detail::select(T(p) < present_, q, T(1));
    else
      return q;
  }

  // Multiplies by m_p relative to the largest m_p among the particles that count: the product
  // stays in range.
  void multiply_by_particle_weights(bool slopes) {
    T largest = T(0);
    for (int p = 0; p < count_; ++p)
      largest = detail::larger(detail::select(w_[p] > T(0), particle_weight_[p], T(0)), largest);
    const T inverse = T(1) / detail::select(largest > T(0), largest, T(1));
    for (int p = 0; p < count_; ++p) {
      const T ratio = detail::select(w_[p] > T(0), T(particle_weight_[p] * inverse), T(0));
      w_[p] *= ratio;
      for (int d = 0; slopes && d < D; ++d) dw_[d][p] *= ratio;
    }
  }

  // The sign of a number: -1, 0 or 1.
  static T sign(const T& x) {
    return detail::select(x > T(0), T(1), detail::select(x < T(0), T(-1), T(0)));
  }

  // Turns dw_ into d w / d x: xi = (x_p - x) / rho gives d xi_d = -(e_d + xi_d grad rho) / rho.
  void differentiate(WeightForm form, Scalar support_factor) {
    const std::array<T, D> grow = support_gradient(form, support_factor);
    for (int p = 0; p < count_; ++p) {
      T along = T(0);
      for (int d = 0; d < D; ++d) along += dw_[d][p] * xi_[d][p];
      for (int d = 0; d < D; ++d) dw_[d][p] = -(dw_[d][p] + along * grow[d]) / rho_;
    }
  }

  // The gradient of rho = support_factor * distance to the farthest neighbour; 0 for supports
  // that stand still.
  std::array<T, D> support_gradient(WeightForm form, Scalar support_factor) const {
    using std::abs;
    std::array<T, D> gradient{};
    if (!(support_factor > Scalar(0))) return gradient;
    const T factor = T(support_factor);
    T distance = T(0);
    for (int p = 0; p < count_; ++p)
      for (int d = 0; d < (form == WeightForm::radial ? 1 : D); ++d) {
        auto farther = q_[d][p] > distance;
        if constexpr (lanes > 1) farther = farther && T(p) < present_;
        if (!detail::any_lane(farther)) continue;
        distance = detail::select(farther, q_[d][p], distance);
        for (int e = 0; e < D; ++e) {
          const T direction = form == WeightForm::radial
                                  ? T(xi_[e][p] / detail::select(farther, q_[d][p], T(1)))
                              : e == d ? sign(xi_[e][p])
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

  void compact(bool slopes) {
    T largest = T(0);
    for (int p = 0; p < count_; ++p) largest = detail::larger(w_[p], largest);
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
      for (int p = 0; p < count_; ++p) {
        const auto keep = usable && w_[p] > least;
        w_[p] = detail::select(keep, T(w_[p] * inverse), T(0));
        weighted_ += detail::select(keep, T(1), T(0));
        for (int d = 0; slopes && d < D; ++d)
          dw_[d][p] = detail::select(keep, T(dw_[d][p] * inverse), T(0));
      }
    } else {
      place_.clear();
      for (int p = 0; usable && p < count_; ++p) {
        if (!(w_[p] > least)) continue;
        const std::size_t to = place_.size();
        for (int d = 0; d < D; ++d) {
          xi_[d][to] = xi_[d][p];
          if (slopes) dw_[d][to] = dw_[d][p] * inverse;
        }
        w_[to] = w_[p] * inverse;
        place_.push_back(p);
      }
      weighted_ = T(static_cast<int>(place_.size()));
    }
  }

  int count_ = 0;
  T present_ = T(0), weighted_ = T(0), rho_ = T(1), noise_ = T(0);
  std::array<std::vector<T>, D> xi_, q_, factor_, slope_, dw_;
  std::vector<T> w_, particle_weight_, pair_ratio_;
  bool weighs_particles_ = false, has_pair_supports_ = false;
  std::vector<int> place_;
};

}  // namespace recon
