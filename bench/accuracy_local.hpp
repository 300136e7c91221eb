// The local problems of all targets, made once: to run the template layer's solvers by themselves.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "recon/local_solve/local_cloud.hpp"
#include "recon/local_solve/orthonormal_fit.hpp"
#include "recon/neighbourhood/neighbour_list.hpp"
#include "recon/points/generate.hpp"
#include "recon/weights/weight.hpp"

namespace recon_bench {

// Offsets (x_p - x) / rho and radial weights, the largest 1. All neighbours need w > 0.
template <class T, int D>
class LocalProblems {
 public:
  LocalProblems(const recon::PointList<T, D>& points, const recon::PointList<T, D>& targets,
                const recon::NeighbourList<T>& list, const recon::WeightFunction& weight)
      : list_(list), targets_(targets), w_(list.indices.size()) {
    std::vector<T> q(list.indices.size());
    for (auto& axis : xi_) axis.resize(list.indices.size());
    for (std::size_t t = 0; t < targets.size(); ++t)
      for (std::int64_t e = list.offsets[t]; e < list.offsets[t + 1]; ++e) {
        T q2 = 0;
        for (int d = 0; d < D; ++d) {
          const T xi = (points[list.indices[e]][d] - targets[t][d]) / list.support[t];
          xi_[d][e] = xi;
          q2 += xi * xi;
        }
        q[e] = std::sqrt(q2);
      }
    weight.evaluate(q.data(), w_.data(), nullptr, q.size());
    for (std::size_t t = 0; t < targets.size(); ++t) {
      T* begin = w_.data() + list.offsets[t];
      T* end = w_.data() + list.offsets[t + 1];
      if (begin == end) continue;
      const T largest = *std::max_element(begin, end);
      for (T* w = begin; w < end; ++w) *w /= largest;
    }
  }

  std::size_t size() const { return targets_.size(); }
  std::size_t most_neighbours() const {
    std::int64_t most = 0;
    for (std::size_t t = 0; t < size(); ++t) most = std::max(most, list_.count(t));
    return static_cast<std::size_t>(most);
  }

  recon::LocalCloud<T, D> operator[](std::size_t t) const {
    const std::int64_t begin = list_.offsets[t];
    recon::LocalCloud<T, D> cloud;
    cloud.size = static_cast<int>(list_.count(t));
    for (int d = 0; d < D; ++d) cloud.xi[d] = xi_[d].data() + begin;
    cloud.w = w_.data() + begin;
    cloud.rho = list_.support[t];
    T extent = 0;
    for (const T c : targets_[t]) extent = std::max(extent, std::abs(c));
    cloud.noise = std::numeric_limits<T>::epsilon() * (extent + cloud.rho) / cloud.rho;
    return cloud;
  }

 private:
  const recon::NeighbourList<T>& list_;
  const recon::PointList<T, D>& targets_;
  std::array<std::vector<T>, D> xi_;
  std::vector<T> w_;
};

// max |u_i . u_j - delta_ij| of the columns that a solver calls orthonormal.
template <class T, int D>
double loss_of_orthogonality(const recon::OrthonormalFit<T, D>& fit) {
  double loss = 0;
  for (int i = 0; i < fit.rank(); ++i)
    for (int j = 0; j <= i; ++j) {
      long double dot = i == j ? -1 : 0;
      for (int p = 0; p < fit.size(); ++p)
        dot += static_cast<long double>(fit.column(i)[p]) * fit.column(j)[p];
      loss = std::max(loss, static_cast<double>(std::abs(dot)));
    }
  return loss;
}

}  // namespace recon_bench
