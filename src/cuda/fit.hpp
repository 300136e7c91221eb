// The fits of targets whose rows have been found, by the library's own kernels of one target.
//
// First come all targets, by the fast half of the solver that is asked for (MomentMatrix or
// RegularGramSchmidt) in memory of the thread's own. Those that are not safe, and those with more
// neighbours than there is room for, are gathered and fitted by SafeSolve in memory that is handed
// in: the way to decide is that of the processor.
#pragma once

#include <type_traits>

#include "cuda/neighbours.hpp"
#include "recon/local_solve/safe_solve.hpp"
#include "recon/shape/stencil.hpp"
#include "recon/weights/weight.hpp"

namespace recon::cuda {

// A built-in weight, chosen outside the loop over the neighbours.
struct AnyWeight {
  Weight kind = Weight::cubic_b_spline;

  template <class T>
  RECON_DEVICE void evaluate(const T* q, T* w, T* slope, int n) const {
    switch (kind) {
      case Weight::linear_b_spline:
        return of(BSpline<1>{}, q, w, slope, n);
      case Weight::quadratic_b_spline:
        return of(BSpline<2>{}, q, w, slope, n);
      case Weight::cubic_b_spline:
        return of(BSpline<3>{}, q, w, slope, n);
      case Weight::quartic_b_spline:
        return of(BSpline<4>{}, q, w, slope, n);
      case Weight::quintic_b_spline:
        return of(BSpline<5>{}, q, w, slope, n);
      case Weight::wendland_c0:
        return of(Wendland<0>{}, q, w, slope, n);
      case Weight::wendland_c2:
        return of(Wendland<2>{}, q, w, slope, n);
      case Weight::wendland_c4:
        return of(Wendland<4>{}, q, w, slope, n);
      case Weight::wendland_c6:
        return of(Wendland<6>{}, q, w, slope, n);
      case Weight::gaussian:
        return of(Gaussian{}, q, w, slope, n);
      case Weight::inverse_distance:
        return of(InverseDistance{}, q, w, slope, n);
    }
  }

 private:
  template <class W, class T>
  RECON_DEVICE static void of(const W& weight, const T* q, T* w, T* slope, int n) {
    for (int i = 0; i < n; ++i) {
      if (slope) slope[i] = q[i] < T(1) ? T(weight.derivative(q[i])) : T(0);
      w[i] = q[i] < T(1) ? T(weight(q[i])) : T(0);
    }
  }
};

// Memory of the thread for `most` neighbours, as RoomFor (core/memory.hpp), but not set to zero.
template <int most>
struct Room {
  template <class U, std::size_t fixed, std::size_t each>
  struct Store {
    U numbers[fixed + each * most];
    constexpr Store() {}
    constexpr std::size_t size() const { return fixed + each * most; }
    constexpr U* data() { return numbers; }
    constexpr const U* data() const { return numbers; }
    constexpr U& operator[](std::size_t i) { return numbers[i]; }
    constexpr const U& operator[](std::size_t i) const { return numbers[i]; }
  };
  template <class U, std::size_t fixed, std::size_t each>
  constexpr Store<U, fixed, each> make() const {
    return Store<U, fixed, each>();
  }
};

// What is fitted, and where the results go: `value` has a number for each entry, and the others, if
// not null, D for the gradient and D (D + 1) / 2 for the Hessian, or 1 for the Laplacian.
template <int D, class T>
struct FitTask {
  const T *particles, *targets;  // [place][axis], [row][axis]
  Rows<T> rows;
  Frame<D, T> frame;
  T support_factor;
  FitTolerances tolerances;
  AnyWeight weight;
  Solver solver;
  T *value = nullptr, *gradient = nullptr, *hessian = nullptr, *laplacian = nullptr;
  Derivative kind = Derivative::exact;
  FitReport* reports = nullptr;     // of the caller's targets; null: nobody wants them
  const std::uint32_t* target_of;   // the caller's number of each row
  std::uint32_t* others = nullptr;  // 1 for a row that is not fitted in the first pass

  RECON_DEVICE bool second() const { return hessian != nullptr || laplacian != nullptr; }
  RECON_DEVICE bool slopes() const { return gradient != nullptr && kind == Derivative::exact; }
};

template <int D, class T, class Memory>
RECON_DEVICE LocalCloud<T, D> gather(const FitTask<D, T>& task, std::size_t t, int count,
                                     Stencil<T, D, Memory>& stencil) {
  std::array<T, D> x;
  for (int d = 0; d < D; ++d) x[d] = task.targets[t * D + d];
  stencil.start(x, count > 0 ? task.rows.support[t] : T(1), count);
  const std::int64_t first = task.rows.offsets[t];
  const bool periodic = task.frame.any_period();
  T* offsets[D];
  for (int d = 0; d < D; ++d) offsets[d] = stencil.offsets(d);
  for (int i = 0; i < count; ++i) {
    const T* const at = task.particles + std::size_t{task.rows.places[first + i]} * D;
    for (int d = 0; d < D; ++d) offsets[d][i] = at[d] - x[d];
    if (!periodic) continue;
    const ImageShift shift = detail::NeighbourKey<true>::shift(task.rows.shifts[first + i]);
    for (int d = 0; d < D; ++d)
      if (task.frame.periodic[d]) offsets[d][i] += static_cast<T>(shift[d]) * task.frame.period[d];
  }
  stencil.weigh(task.weight, WeightForm::radial, task.slopes(), task.support_factor);
  return stencil.cloud();
}

// How many numbers for each particle shape functions need.
template <int D>
RECON_DEVICE constexpr int numbers_for(bool gradient, bool second) {
  return second ? detail::jet_size(D) : gradient ? 1 + D : 1;
}

template <class T>
RECON_DEVICE void fill(T* to, std::int64_t count) {
  for (std::int64_t i = 0; i < count; ++i) to[i] = T(0);
}

// Zeros for the whole row: particles without a weight, and targets without a fit.
template <int D, class T>
RECON_DEVICE void clear_row(const FitTask<D, T>& task, std::size_t t) {
  constexpr int seconds = D * (D + 1) / 2;
  const std::int64_t first = task.rows.offsets[t], count = task.rows.offsets[t + 1] - first;
  if (task.value) fill(task.value + first, count);
  if (task.gradient) fill(task.gradient + first * D, count * D);
  if (task.hessian) fill(task.hessian + first * seconds, count * seconds);
  if (task.laplacian) fill(task.laplacian + first, count);
}

// Writes the shape functions of a fit into row t. `numbers` is memory for numbers_for() times
// cloud.size of them.
template <int D, class T, class Memory, class Solve>
RECON_DEVICE void write_row(const FitTask<D, T>& task, std::size_t t, const LocalCloud<T, D>& cloud,
                            const Stencil<T, D, Memory>& stencil, Solve& solve, T* numbers) {
  constexpr int seconds = D * (D + 1) / 2;
  const std::int64_t first = task.rows.offsets[t];
  const int n = cloud.size;
  if (n < task.rows.offsets[t + 1] - first) clear_row(task, t);
  const bool second = task.second();
  const auto out = ShapeArrays<T, D>::in(numbers, n, task.kind, task.gradient != nullptr, second);
  solve.shape_functions(cloud, out);
  T scale[D];
  for (int d = 0; d < D; ++d) scale[d] = static_cast<T>(1 / task.frame.stretch[d]);
  for (int p = 0; p < n; ++p) {
    const std::int64_t e = first + stencil.place(p);
    if (task.value) task.value[e] = out.value[p];
    for (int d = 0; d < D && task.gradient; ++d)
      task.gradient[e * D + d] = out.gradient[d][p] * scale[d];
    T trace = 0;
    int i = 0;
    for (int a = 0; a < D && second; ++a)
      for (int b = a; b < D; ++b, ++i) {
        const T here = out.hessian[i][p] * scale[a] * scale[b];
        if (task.hessian) task.hessian[e * seconds + i] = here;
        if (a == b) trace += here;
      }
    if (task.laplacian) task.laplacian[e] = trace;
  }
}

template <int D, class T>
RECON_DEVICE int count_of_row(const FitTask<D, T>& task, std::size_t t) {
  // A row that could not be found has no support.
  if (!(task.rows.support[t] > T(0))) return 0;
  return static_cast<int>(task.rows.offsets[t + 1] - task.rows.offsets[t]);
}
template <int D, class T>
RECON_DEVICE void write_report(const FitTask<D, T>& task, std::size_t t, const FitReport& report) {
  if (task.reports) task.reports[task.target_of[t]] = report;
}

// One target, by the fast half of a solver: MomentMatrix<T, B> or RegularGramSchmidt<T, B, 2, Memory>.
template <int D, int R, class T, Solver solver, int room, bool derivatives>
struct FitSafe {
  using B = Monomials<D, R>;
  using Memory = Room<room>;
  using Fit = std::conditional_t<solver == Solver::moment_matrix, MomentMatrix<T, B>,
                                 RegularGramSchmidt<T, B, 2, Memory>>;
  FitTask<D, T> task;

  RECON_DEVICE void operator()(std::size_t t) const {
    const int count = count_of_row(task, t);
    task.others[t] = count > room;
    if (count > room) return;
    Stencil<T, D, Memory> stencil{Memory{}};
    const LocalCloud<T, D> cloud = gather(task, t, count, stencil);
    if (cloud.size == 0) {
      write_report(task, t, detail::report_of<B>({}, {}));
      return clear_row(task, t);
    }
    Fit fit = make();
    if (!(fit.fit(cloud) && fit.gradient_resolved())) {
      task.others[t] = 1;
      return;
    }
    write_report(task, t, detail::report_of<B>(detail::numbers_of(solver, cloud.size, fit)));
    T numbers[(derivatives ? detail::jet_size(D) : 1) * room];
    write_row(task, t, cloud, stencil, fit, numbers);
  }

 private:
  RECON_DEVICE Fit make() const {
    if constexpr (solver == Solver::moment_matrix)
      return Fit(task.tolerances);
    else
      return Fit(task.tolerances, Memory{});
  }
};

// The others, by a few workers that share them out: worker w has those numbered w, w + workers, ...
template <int D, int R, class T>
struct FitOthers {
  using B = Monomials<D, R>;
  using Solve = SafeSolve<T, B, Given>;
  FitTask<D, T> task;
  const std::uint32_t *list, *count;
  std::size_t workers;
  std::byte* memory;  // `bytes` for each worker
  std::size_t bytes;
  int most;  // neighbours of a row

  static constexpr std::size_t bytes_for(int most) {
    const std::size_t all = Solve::bytes_for(most) + Stencil<T, D, Given>::bytes_for(most) +
                            Workspace::bytes_for<T>(static_cast<std::size_t>(detail::jet_size(D)) *
                                                    static_cast<std::size_t>(most));
    return (all + 255) / 256 * 256;
  }

  RECON_DEVICE void operator()(std::size_t w) const {
    if (w >= *count) return;
    Workspace workspace({memory + w * bytes, bytes});
    const Given given(workspace, most);
    Stencil<T, D, Given> stencil(given);
    Solve solve(task.solver, task.tolerances, given);
    T* const numbers =
        workspace
            .take<T>(static_cast<std::size_t>(detail::jet_size(D)) * static_cast<std::size_t>(most))
            .data();
    for (std::size_t i = w; i < *count; i += workers) {
      const std::size_t t = list[i];
      const LocalCloud<T, D> cloud = gather(task, t, count_of_row(task, t), stencil);
      const FitReport report = solve.fit(cloud);
      write_report(task, t, report);
      if (report.rank == 0)
        clear_row(task, t);
      else
        write_row(task, t, cloud, stencil, solve, numbers);
    }
  }
};

// list[at[t]] = t where flags[t], at being the sum of the flags before t.
struct Select {
  const std::uint32_t *flags, *at;
  std::uint32_t* list;
  RECON_DEVICE void operator()(std::size_t t) const {
    if (flags[t]) list[at[t]] = static_cast<std::uint32_t>(t);
  }
};
struct SetFlag {
  std::uint32_t* to;
  RECON_DEVICE void operator()(std::size_t) const { *to = 0; }
};

}  // namespace recon::cuda
