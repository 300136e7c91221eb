// The implementation of lanes.hpp for one scalar and dimension; included by lanes_*.simd.cpp.
#pragma once

#include <vector>

#include "recon/core/pack.hpp"
#include "recon/local_solve/moment_matrix.hpp"
#include "recon/local_solve/regular_gram_schmidt.hpp"
#include "recon/shape/stencil.hpp"
#include "shape/lanes.hpp"

namespace recon::RECON_SET {

namespace {

// A fit of some degree by some solver: all else is the same code for all of them.
template <class T, int D>
struct LaneFit {
  struct Outcome {
    MaskOf<T> safe;  // with a gradient that is resolved; the rest holds there
    T smallest_pivot, amplification, gradient_amplification;
  };
  void* fit;
  void (*run)(void* fit, const LocalCloud<T, D>& cloud, Outcome& outcome);
  void (*shape_functions)(void* fit, const LocalCloud<T, D>& cloud, const ShapeArrays<T, D>& out);
  void (*destroy)(void* fit);
};

template <class Fit, class T, int D>
LaneFit<T, D> make_fit(const FitTolerances& tolerances) {
  return {new Fit(tolerances),
          [](void* fit, const LocalCloud<T, D>& cloud, typename LaneFit<T, D>::Outcome& outcome) {
            Fit& own = *static_cast<Fit*>(fit);
            outcome.safe = own.fit(cloud);
            if (detail::any_lane(outcome.safe))
              outcome.safe = outcome.safe && own.gradient_resolved();
            outcome.smallest_pivot = own.smallest_pivot();
            outcome.amplification = own.amplification();
            outcome.gradient_amplification = own.gradient_amplification();
          },
          [](void* fit, const LocalCloud<T, D>& cloud, const ShapeArrays<T, D>& out) {
            static_cast<Fit*>(fit)->shape_functions(cloud, out);
          },
          [](void* fit) { delete static_cast<Fit*>(fit); }};
}

template <class Scalar, int D>
class Lanes {
  using T = Pack<Scalar>;
  static constexpr int lanes = LaneTraits<T>::lanes;
  static constexpr int seconds = D * (D + 1) / 2;

 public:
  template <class Fit>
  static constexpr detail::LaneFunctions<Scalar> functions() {
    return {[](const FitTolerances& tolerances) -> void* {
              return new Lanes(make_fit<Fit, T, D>(tolerances));
            },
            [](void* worker, const detail::LaneTask<Scalar>& task) {
              static_cast<Lanes*>(worker)->run(task);
            },
            [](void* worker) { delete static_cast<Lanes*>(worker); }};
  }

 private:
  explicit Lanes(const LaneFit<T, D>& fit) : fit_(fit) {}
  Lanes(const Lanes&) = delete;
  Lanes& operator=(const Lanes&) = delete;
  ~Lanes() { fit_.destroy(fit_.fit); }

  void run(const detail::LaneTask<Scalar>& task) {
    task_ = task;
    slopes_ = task.rows.gradient && task.rows.kind == Derivative::exact;
    for (std::size_t i = task.begin; i < task.end; i += lanes) group(i);
  }

  // A weight function takes arrays of packs as arrays of numbers.
  struct Weights {
    const detail::LaneTask<Scalar>& task;
    void evaluate(const T* q, T* w, T* slope, int n) const {
      task.weigh(task.weight, reinterpret_cast<const Scalar*>(q), reinterpret_cast<Scalar*>(w),
                 reinterpret_cast<Scalar*>(slope), static_cast<std::size_t>(n) * lanes);
    }
  };

  // Prefetches the particles of the targets i, i + 1, ... while others are worked on.
  void fetch(std::size_t i) {
    const std::size_t end = i + lanes < task_.end ? i + lanes : task_.end;
    for (std::int64_t e = i < end ? task_.offsets[i] : 0; i < end && e < task_.offsets[end]; ++e)
      __builtin_prefetch(task_.particles + std::size_t{task_.indices[e]} * D);
  }

  // Treats the targets i, i + 1, ...: as many as there are lanes, or as are left.
  void group(std::size_t i) {
    const int used = static_cast<int>(task_.end - i < std::size_t{lanes} ? task_.end - i : lanes);
    int most = 0;
    T rho = T(1), present = T(0);
    std::array<T, D> x;
    for (T& c : x) c = T(0);
    for (int l = 0; l < used; ++l) {
      const std::size_t t = i + l;
      row_[l] = task_.offsets[t];
      count_[l] = static_cast<int>(task_.offsets[t + 1] - task_.offsets[t]);
      // The reciprocal of a tiny support overflows; such a target is treated by itself.
      if (!(task_.support[t] > 8 * std::numeric_limits<Scalar>::min())) count_[l] = 0;
      if (count_[l] > 0) rho[l] = task_.support[t];
      present[l] = static_cast<Scalar>(count_[l]);
      for (int d = 0; d < D; ++d) x[d][l] = task_.targets[(t - task_.begin) * D + d];
      most = count_[l] > most ? count_[l] : most;
    }
    for (int l = used; l < lanes; ++l) count_[l] = 0;
    if (most == 0) return;
    stencil_.start(x, rho, most, present);
    for (int l = 0; l < lanes; ++l) gather(l, most, x);
    if (task_.particle_weights) gather_particle_weights(most);
    if (task_.pair_support) gather_pair_supports(most);
    if (task_.pair_distances) gather_pair_distances(most);
    fetch(i + lanes);
    stencil_.weigh(Weights{task_}, task_.form, slopes_, task_.support_factor);
    const LocalCloud<T, D> cloud = stencil_.cloud();
    typename LaneFit<T, D>::Outcome outcome;
    fit_.run(fit_.fit, cloud, outcome);
    if (!detail::any_lane(outcome.safe)) return;

    values_.resize(static_cast<std::size_t>(most) * detail::jet_size(D));
    const auto out = ShapeArrays<T, D>::in(values_.data(), most, task_.rows.kind,
                                           task_.rows.gradient, task_.rows.hessian);
    fit_.shape_functions(fit_.fit, cloud, out);
    for (int l = 0; l < used; ++l) {
      if (!outcome.safe[l]) continue;
      scatter(l, out);
      detail::LaneReport& report = task_.reports[i + l - task_.begin];
      const auto number = [l](const T& lane) {
        return static_cast<float>(static_cast<Scalar>(lane[l]));
      };
      report.numbers = {task_.solver,
                        static_cast<std::uint32_t>(static_cast<Scalar>(stencil_.weighted()[l])),
                        number(outcome.smallest_pivot), number(outcome.amplification),
                        number(outcome.gradient_amplification)};
      report.done = true;
    }
  }

  void gather(int l, int most, const std::array<T, D>& x) {
    const int n = count_[l];
    const ParticleIndex* index = task_.indices + (n > 0 ? row_[l] : 0);
    std::array<Scalar*, D> offset;
    std::array<Scalar, D> centre;
    for (int d = 0; d < D; ++d) {
      offset[d] = stencil_.offsets(d) + l;
      centre[d] = x[d][l];
    }
    if (task_.local_offsets) {
      const Scalar* local = task_.local_offsets + (n > 0 ? entry(l) * D : 0);
      for (int p = 0; p < n; ++p)
        for (int d = 0; d < D; ++d) offset[d][p * lanes] = local[p * D + d];
    } else {
      for (int p = 0; p < n; ++p) {
        const Scalar* at = task_.particles + std::size_t{index[p]} * D;
        for (int d = 0; d < D; ++d) offset[d][p * lanes] = at[d] - centre[d];
      }
    }
    if (task_.shifts && !task_.local_offsets && n > 0) {
      const std::int8_t* shift = reinterpret_cast<const std::int8_t*>(task_.shifts + row_[l]);
      for (int p = 0; p < n; ++p)
        for (int d = 0; d < D; ++d)
          offset[d][p * lanes] +=
              static_cast<Scalar>(shift[p * max_dimension + d]) * task_.period[d];
    }
    for (int p = n; p < most; ++p)
      for (int d = 0; d < D; ++d) offset[d][p * lanes] = 0;
  }

  void gather_particle_weights(int most) {
    Scalar* weights = stencil_.particle_weights();
    for (int l = 0; l < lanes; ++l) {
      const int n = count_[l];
      const ParticleIndex* index = task_.indices + (n > 0 ? row_[l] : 0);
      for (int p = 0; p < n; ++p) weights[p * lanes + l] = task_.particle_weights[index[p]];
      for (int p = n; p < most; ++p) weights[p * lanes + l] = 0;
    }
  }

  void gather_pair_supports(int most) {
    Scalar* supports = stencil_.pair_supports();
    for (int l = 0; l < lanes; ++l) {
      const int n = count_[l];
      for (int p = 0; p < n; ++p) supports[p * lanes + l] = task_.pair_support[row_[l] + p];
      for (int p = n; p < most; ++p) supports[p * lanes + l] = 1;
    }
  }

  void gather_pair_distances(int most) {
    const int slopes = slopes_ ? D : 0;
    Scalar* distance = stencil_.pair_distances();
    std::array<Scalar*, D> slope{};
    for (int d = 0; d < slopes; ++d) slope[d] = stencil_.pair_slopes(d);
    for (int l = 0; l < lanes; ++l) {
      const int n = count_[l];
      const std::int64_t first = n > 0 ? entry(l) : 0;
      for (int p = 0; p < n; ++p) {
        distance[p * lanes + l] = task_.pair_distances[first + p];
        for (int d = 0; d < slopes; ++d)
          slope[d][p * lanes + l] = task_.pair_slopes[(first + p) * D + d];
      }
      for (int p = n; p < most; ++p) {
        distance[p * lanes + l] = 1;
        for (int d = 0; d < slopes; ++d) slope[d][p * lanes + l] = 0;
      }
    }
  }

  // The first entry of a lane, from the first of the task on.
  std::int64_t entry(int l) const { return row_[l] - task_.offsets[task_.begin]; }

  void scatter(int l, const ShapeArrays<T, D>& out) {
    const int n = count_[l];
    const auto lane = [l](const T* array) { return reinterpret_cast<const Scalar*>(array) + l; };
    if (task_.rows.value) {
      const Scalar* value = lane(out.value);
      Scalar* row = task_.rows.value + row_[l];
      for (int p = 0; p < n; ++p) row[p] = value[p * lanes];
    }
    for (int d = 0; d < D && task_.rows.gradient; ++d) {
      const Scalar* slope = lane(out.gradient[d]);
      Scalar* row = task_.rows.gradient + row_[l] * D + d;
      for (int p = 0; p < n; ++p) row[p * D] = slope[p * lanes] * task_.axis_scale[d];
    }
    int entry = 0;
    for (int a = 0; a < D && task_.rows.hessian; ++a)
      for (int b = a; b < D; ++b, ++entry) {
        const Scalar* second = lane(out.hessian[entry]);
        Scalar* row = task_.rows.hessian + row_[l] * seconds + entry;
        for (int p = 0; p < n; ++p)
          row[p * seconds] = second[p * lanes] * task_.axis_scale[a] * task_.axis_scale[b];
      }
  }

  detail::LaneTask<Scalar> task_;
  bool slopes_ = false;
  Stencil<T, D> stencil_;
  LaneFit<T, D> fit_;
  std::vector<T> values_;
  std::array<std::int64_t, lanes> row_{};
  std::array<int, lanes> count_{};
};

template <class Scalar, int D, int R>
detail::LaneFunctions<Scalar> of_solver(Solver solver) {
  using T = Pack<Scalar>;
  using Basis = Monomials<D, R>;
  if (solver == Solver::moment_matrix)
    return Lanes<Scalar, D>::template functions<MomentMatrix<T, Basis>>();
  if (solver == Solver::gram_schmidt)
    return Lanes<Scalar, D>::template functions<RegularGramSchmidt<T, Basis>>();
  return {};
}

}  // namespace

template <class Scalar, int D>
detail::LaneFunctions<Scalar> lane_functions(int degree, Solver solver) {
  switch (degree) {
    case 0:
      return of_solver<Scalar, D, 0>(solver);
    case 1:
      return of_solver<Scalar, D, 1>(solver);
    case 2:
      return of_solver<Scalar, D, 2>(solver);
    case 3:
      return of_solver<Scalar, D, 3>(solver);
    case 4:
      return of_solver<Scalar, D, 4>(solver);
    default:
      return {};
  }
}

}  // namespace recon::RECON_SET
