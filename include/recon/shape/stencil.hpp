// From neighbours to a local problem: scaled offsets, weights and their slopes for one target.
//
//     xi = (x_p - x) / rho,   radial: w = w(|xi|),   tensor product: w = prod_d w(|xi_d|),
//     d w / d x = -(sum_d dw/dxi_d (e_d + xi_d grad rho)) / rho .
// Weights are divided by the largest, so that a fit does not see their scale. The arrays are kept
// from target to target: nothing is allocated once warm. Use one object per thread.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "recon/local_solve/local_cloud.hpp"
#include "recon/weights/weight.hpp"

namespace recon {

template <class Scalar, int D>
class Stencil {
 public:
  // Begins a target at x with support rho and this many neighbours.
  void start(const std::array<Scalar, D>& x, Scalar rho, int count) {
    count_ = count;
    rho_ = rho;
    Scalar size = 0;
    for (int d = 0; d < D; ++d) size = std::max(size, std::abs(x[d]));
    noise_ = std::numeric_limits<Scalar>::epsilon() * (size + rho) / rho;
    w_.resize(count);
    for (int d = 0; d < D; ++d)
      for (auto* array : {&xi_[d], &q_[d], &factor_[d], &slope_[d], &dw_[d]}) array->resize(count);
  }

  // offset(p) = x_p - x along axis d, a length.
  template <class Offset>
  void set_offsets(int d, Offset&& offset) {
    for (int p = 0; p < count_; ++p) xi_[d][p] = offset(p) / rho_;
  }

  // Evaluates the weights, with `slopes` their derivatives too, and drops the particles whose
  // weight is not above eps^2 of the largest: those change nothing in working precision.
  // support_factor as in ShapeProblem.
  template <class Weights>
  void weigh(const Weights& weights, WeightForm form, bool slopes, Scalar support_factor = 0) {
    evaluate_weights(weights, form, slopes);
    if (slopes) differentiate(form, support_factor);
    compact(slopes);
  }

  LocalCloud<Scalar, D> cloud() const {
    LocalCloud<Scalar, D> cloud;
    cloud.size = static_cast<int>(place_.size());
    cloud.rho = rho_;
    cloud.noise = noise_;
    cloud.w = w_.data();
    for (int d = 0; d < D; ++d) {
      cloud.xi[d] = xi_[d].data();
      cloud.dw[d] = dw_[d].data();
    }
    return cloud;
  }

  // Where particle p of the cloud stands in the target's row of the neighbour list.
  int place(int p) const { return place_[p]; }

 private:
  // w_ and, with slopes, dw_ = d w / d xi. Radial: one factor of q = |xi|; tensor product: one per
  // axis.
  template <class Weights>
  void evaluate_weights(const Weights& weights, WeightForm form, bool slopes) {
    if (form == WeightForm::radial) {
      for (int p = 0; p < count_; ++p) {
        Scalar q2 = 0;
        for (int d = 0; d < D; ++d) q2 += xi_[d][p] * xi_[d][p];
        q_[0][p] = std::sqrt(q2);
      }
      weights.evaluate(q_[0].data(), w_.data(), slopes ? slope_[0].data() : nullptr, count_);
      if (slopes)
        for (int d = 0; d < D; ++d)
          for (int p = 0; p < count_; ++p)
            dw_[d][p] = q_[0][p] > 0 ? slope_[0][p] * xi_[d][p] / q_[0][p] : Scalar(0);
      return;
    }
    for (int d = 0; d < D; ++d) {
      for (int p = 0; p < count_; ++p) q_[d][p] = std::abs(xi_[d][p]);
      weights.evaluate(q_[d].data(), factor_[d].data(), slopes ? slope_[d].data() : nullptr,
                       count_);
    }
    for (int p = 0; p < count_; ++p) {
      w_[p] = factor_[0][p];
      for (int d = 1; d < D; ++d) w_[p] *= factor_[d][p];
    }
    if (slopes)
      for (int d = 0; d < D; ++d)
        for (int p = 0; p < count_; ++p) {
          Scalar others = slope_[d][p];
          for (int e = 0; e < D; ++e)
            if (e != d) others *= factor_[e][p];
          dw_[d][p] = std::copysign(Scalar(1), xi_[d][p]) * (xi_[d][p] == 0 ? Scalar(0) : others);
        }
  }

  // dw_ becomes d w / d x: xi = (x_p - x) / rho gives d xi_d = -(e_d + xi_d grad rho) / rho.
  void differentiate(WeightForm form, Scalar support_factor) {
    const std::array<Scalar, D> grow = support_gradient(form, support_factor);
    for (int p = 0; p < count_; ++p) {
      Scalar along = 0;
      for (int d = 0; d < D; ++d) along += dw_[d][p] * xi_[d][p];
      for (int d = 0; d < D; ++d) dw_[d][p] = -(dw_[d][p] + along * grow[d]) / rho_;
    }
  }

  // grad rho for rho = support_factor * distance to the farthest neighbour; 0 for supports that
  // stand still.
  std::array<Scalar, D> support_gradient(WeightForm form, Scalar support_factor) const {
    std::array<Scalar, D> gradient{};
    if (support_factor <= 0) return gradient;
    int far = -1, far_axis = 0;
    Scalar distance = 0;
    for (int p = 0; p < count_; ++p) {
      if (form == WeightForm::radial && q_[0][p] > distance) {
        distance = q_[0][p];
        far = p;
      }
      for (int d = 0; d < D && form == WeightForm::tensor_product; ++d)
        if (q_[d][p] > distance) {
          distance = q_[d][p];
          far = p;
          far_axis = d;
        }
    }
    // All neighbours on the target: the support was chosen in another way and stands still.
    if (far < 0 || std::abs(distance * support_factor - 1) > Scalar(1e-3)) return gradient;
    if (form == WeightForm::radial)
      for (int d = 0; d < D; ++d) gradient[d] = -support_factor * xi_[d][far] / distance;
    else
      gradient[far_axis] = -support_factor * std::copysign(Scalar(1), xi_[far_axis][far]);
    return gradient;
  }

  void compact(bool slopes) {
    Scalar largest = 0;
    for (int p = 0; p < count_; ++p) largest = std::max(largest, w_[p]);
    place_.clear();
    if (!(largest >= std::numeric_limits<Scalar>::min())) return;
    const Scalar inverse = 1 / largest;
    const Scalar least =
        largest * std::numeric_limits<Scalar>::epsilon() * std::numeric_limits<Scalar>::epsilon();
    for (int p = 0; p < count_; ++p) {
      if (!(w_[p] > least)) continue;
      const std::size_t to = place_.size();
      for (int d = 0; d < D; ++d) {
        xi_[d][to] = xi_[d][p];
        if (slopes) dw_[d][to] = dw_[d][p] * inverse;
      }
      w_[to] = w_[p] * inverse;
      place_.push_back(p);
    }
  }

  int count_ = 0;
  Scalar rho_ = 1, noise_ = 0;
  std::array<std::vector<Scalar>, D> xi_, q_, factor_, slope_, dw_;
  std::vector<Scalar> w_;
  std::vector<int> place_;
};

}  // namespace recon
