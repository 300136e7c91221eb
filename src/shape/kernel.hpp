// The shape-function kernel for one dimension; compiled once per scalar (kernel_*.cpp).
//
// Targets go through the lanes first, several at a time (lanes.hpp). Those that need a closer look,
// and all targets of the solvers that have no lanes, are treated one by one.
#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "core/pool.hpp"
#include "local_solve/compiled_solve.hpp"
#include "recon/shape/shape_kernel.hpp"
#include "recon/shape/stencil.hpp"
#include "shape/lanes.hpp"
#include "shape/local_frames.hpp"

namespace recon::detail {

template <class Scalar, int D>
class Kernel final : public ShapeKernel<Scalar> {
 public:
  explicit Kernel(const ShapeChoice& choice)
      : choice_(choice),
        lanes_(RECON_DISPATCH(choice.instruction_set, lane_functions<Scalar, D>)(choice.degree,
                                                                                 choice.solver)),
        weigh_(choice.weight.template function<Scalar>(choice.instruction_set)),
        full_(with_degree(choice.degree, [](auto r) { return report_of<Monomials<D, r>>({}); })) {}

  void evaluate(const ShapeProblem<Scalar>& problem, std::size_t begin, std::size_t end,
                const ShapeRows<Scalar>& rows) const override {
    const auto buffers = buffers_.lend([&] { return std::make_unique<Buffers>(choice_, lanes_); });
    std::vector<LaneReport>& reports = buffers->reports;
    reports.assign(end - begin, {});
    const bool slopes = rows.gradient && rows.kind == Derivative::exact;
    const Frames* const frames = prepared(problem, begin, end, slopes, *buffers);
    if (buffers->lanes)
      lanes_.run(buffers->lanes.get(),
                 lane_task(problem, begin, end, frames, rows, reports.data()));

    for (std::size_t i = begin; i < end; ++i) {
      const LaneReport& lane = reports[i - begin];
      FitReport report = full_;
      if (lane.done)
        set_numbers(lane.numbers, report);
      else
        report = buffers->single.evaluate(problem, i, frames, rows);
      if (rows.report) rows.report[i] = report;
    }
    if (frames) frames->turn_back(problem, end, rows);
  }

  void evaluate(const ShapeProblem<Scalar>& problem, std::size_t begin, std::size_t end,
                const FunctionalRows<Scalar>& rows) const override {
    const auto buffers = buffers_.lend([&] { return std::make_unique<Buffers>(choice_, lanes_); });
    const Frames* const frames = prepared(problem, begin, end, false, *buffers);
    for (std::size_t i = begin; i < end; ++i) buffers->single.evaluate(problem, i, frames, rows);
  }

  void forget_buffers() const override { buffers_.clear(); }

 private:
  using Powers = std::array<int, max_dimension>;
  using Frames = LocalFrames<Scalar, D>;

  // Treats one target after another, in its frame where there are frames: derivatives then are
  // those along the axes of the frame.
  class Single {
   public:
    explicit Single(const ShapeChoice& choice)
        : choice_(choice),
          solve_(make_solve<Scalar, D>(choice.degree, choice.solver, choice.tolerances)),
          polynomial_(
              make_solve<Scalar, D>(choice.degree, Solver::gram_schmidt, choice.tolerances)) {}

    FitReport evaluate(const ShapeProblem<Scalar>& problem, std::size_t t, const Frames* frames,
                       const ShapeRows<Scalar>& rows) {
      constexpr int seconds = D * (D + 1) / 2;
      const std::int64_t row = problem.neighbours.offsets[t],
                         row_end = problem.neighbours.offsets[t + 1];
      if (rows.value) std::fill(rows.value + row, rows.value + row_end, Scalar(0));
      if (rows.gradient) std::fill(rows.gradient + row * D, rows.gradient + row_end * D, Scalar(0));
      if (rows.hessian)
        std::fill(rows.hessian + row * seconds, rows.hessian + row_end * seconds, Scalar(0));

      gather(problem, t, frames, rows.gradient && rows.kind == Derivative::exact);
      const LocalCloud<Scalar, D> cloud = stencil_.cloud();
      const FitReport report = solve_->fit(cloud);
      if (report.rank == 0) return report;

      const int n = cloud.size;
      const auto scale = frames ? ShapeProblem<Scalar>::no_scale : problem.axis_scale;
      values_.resize(static_cast<std::size_t>(n) * jet_size(D));
      const auto out =
          ShapeArrays<Scalar, D>::in(values_.data(), n, rows.kind, rows.gradient, rows.hessian);
      solve_->shape_functions(cloud, out);

      for (int p = 0; p < n; ++p) {
        const std::int64_t entry = row + stencil_.place(p);
        if (rows.value) rows.value[entry] = out.value[p];
        for (int d = 0; d < D && rows.gradient; ++d)
          rows.gradient[entry * D + d] = out.gradient[d][p] * scale[d];
        int i = 0;
        for (int a = 0; a < D && rows.hessian; ++a)
          for (int b = a; b < D; ++b, ++i)
            rows.hessian[entry * seconds + i] = out.hessian[i][p] * scale[a] * scale[b];
      }
      return report;
    }

    void evaluate(const ShapeProblem<Scalar>& problem, std::size_t t, const Frames* frames,
                  const FunctionalRows<Scalar>& rows) {
      const auto numbers = static_cast<std::size_t>(rows.numbers);
      Scalar* const values = rows.value + problem.neighbours.offsets[t] * rows.numbers;
      std::fill_n(values, problem.neighbours.count(t) * rows.numbers, Scalar(0));
      gather(problem, t, frames, false);
      const LocalCloud<Scalar, D> cloud = stencil_.cloud();
      if (polynomial_->fit(cloud).rank == 0) return;

      act(problem, t, frames, rows);
      values_.resize(static_cast<std::size_t>(cloud.size));
      for (std::size_t i = 0; i < numbers; ++i) {
        polynomial_->shape_functions_of(on_monomials_.data() + i * jets(), values_.data());
        for (int p = 0; p < cloud.size; ++p)
          values[static_cast<std::size_t>(stencil_.place(p)) * numbers + i] = values_[p];
      }
    }

   private:
    using Terms = Monomials<D, max_compiled_degree>;

    // The number of Taylor coefficients of the polynomials.
    std::size_t jets() const {
      return static_cast<std::size_t>(monomial_count(D, std::max(choice_.degree, 2)));
    }

    // Sets on_monomials_[i * jets() + a] to what functional i makes of monomial a in xi.
    void act(const ShapeProblem<Scalar>& problem, std::size_t t, const Frames* frames,
             const FunctionalRows<Scalar>& rows) {
      const auto numbers = static_cast<std::size_t>(rows.numbers);
      const double rho = static_cast<double>(problem.neighbours.support[t]);
      const int terms = monomial_count(D, choice_.degree);
      on_monomials_.assign(numbers * jets(), Scalar(0));
      actions_.resize(numbers * static_cast<std::size_t>(terms));
      largest_.assign(numbers, 0);
      for (int a = 0; a < terms; ++a) {
        Powers powers{};
        for (int d = 0; d < D; ++d) powers[d] = Terms::exponents[a][d];
        const std::span<double> action = std::span(actions_).subspan(a * numbers, numbers);
        rows.action(t, powers, action);
        if (frames) continue;
        for (double& scaled : action)
          for (int d = 0; d < D; ++d)
            for (int n = 0; n < powers[d]; ++n)
              scaled *= static_cast<double>(problem.axis_scale[d]) / rho;
      }
      if (frames) turn_actions(frames->from_callers(problem, t), rho, terms, numbers);
      for (int a = 0; a < terms; ++a) {
        for (std::size_t i = 0; i < numbers; ++i) {
          const double scaled = actions_[a * numbers + i];
          const Scalar on_monomial = static_cast<Scalar>(scaled);
          require(is_finite(on_monomial), "functional of a monomial, in support radii", scaled,
                  "must be finite and in the range of the precision");
          on_monomials_[i * jets() + a] = on_monomial;
          largest_[i] = std::max(largest_[i], std::abs(scaled));
        }
      }
      // Below the smallest normal number digits are lost.
      for (const double largest : largest_)
        require(largest == 0 || static_cast<Scalar>(largest) >= std::numeric_limits<Scalar>::min(),
                "functional of a monomial, in support radii", largest,
                "must be a normal number of the precision: choose another unit of length");
    }

    // From what functionals make of monomials in x_p - x to what they make of those in xi = map
    // (x_p - x) / rho, which are sums of monomials of the same degree.
    void turn_actions(const std::array<std::array<double, D>, D>& map, double rho, int terms,
                      std::size_t numbers) {
      // Row a: the coefficients of monomial a in xi; it is one of a lower degree times a component.
      turn_.assign(static_cast<std::size_t>(terms * terms), 0);
      turn_[0] = 1;
      for (int a = 1; a < terms; ++a) {
        auto lower = Terms::exponents[a];
        int axis = 0;
        while (lower[axis] == 0) ++axis;
        --lower[axis];
        const int from = Terms::find(lower);
        for (int b = 0; b < terms; ++b) {
          const double coefficient = turn_[from * terms + b];
          for (int d = 0; coefficient != 0 && d < D; ++d) {
            auto higher = Terms::exponents[b];
            ++higher[d];
            turn_[a * terms + Terms::find(higher)] += coefficient * map[axis][d] / rho;
          }
        }
      }
      const std::vector<double> given = actions_;
      for (int a = 0; a < terms; ++a)
        for (std::size_t i = 0; i < numbers; ++i) {
          double sum = 0;
          for (int b = 0; b < terms; ++b)
            if (turn_[a * terms + b] != 0) sum += turn_[a * terms + b] * given[b * numbers + i];
          actions_[a * numbers + i] = sum;
        }
    }

    void gather(const ShapeProblem<Scalar>& problem, std::size_t t, const Frames* frames,
                bool slopes) {
      const auto& list = problem.neighbours;
      const int n = static_cast<int>(list.count(t));
      if (frames) {
        gather_in_frame(problem, t, *frames, slopes);
      } else {
        gather_offsets(problem, t);
      }
      if (problem.particle_weights) {
        const ParticleIndex* index = list.indices + list.offsets[t];
        Scalar* weights = stencil_.particle_weights();
        for (int p = 0; p < n; ++p) weights[p] = problem.particle_weights[index[p]];
      }
      if (list.pair_support)
        std::copy_n(list.pair_support + list.offsets[t], n, stencil_.pair_supports());
      stencil_.weigh(choice_.weight, choice_.form, slopes, list.support_factor);
    }

    void gather_in_frame(const ShapeProblem<Scalar>& problem, std::size_t t, const Frames& frames,
                         bool slopes) {
      const auto& list = problem.neighbours;
      const std::int64_t first = list.offsets[t];
      const int n = static_cast<int>(list.count(t));
      std::array<Scalar, D> size;
      std::copy_n(frames.size(t), D, size.begin());
      stencil_.start(size, list.support[t], n);
      for (int d = 0; d < D; ++d) {
        Scalar* offset = stencil_.offsets(d);
        for (int p = 0; p < n; ++p) offset[p] = frames.offset(first + p)[d];
      }
      if (!list.pair_tensor) return;
      std::copy_n(frames.distance(first), n, stencil_.pair_distances());
      for (int d = 0; d < D && slopes; ++d) {
        Scalar* slope = stencil_.pair_slopes(d);
        for (int p = 0; p < n; ++p) slope[p] = frames.slope(first + p)[d];
      }
    }

    void gather_offsets(const ShapeProblem<Scalar>& problem, std::size_t t) {
      const auto& list = problem.neighbours;
      const std::array<Scalar, D> x = problem.targets.template point<D>(t);
      const ParticleIndex* index = list.indices + list.offsets[t];
      const int n = static_cast<int>(list.count(t));
      stencil_.start(x, list.support[t], n);
      for (int d = 0; d < D; ++d) {
        const Scalar* particles = problem.particles.data();  // null where there are none
        Scalar* offset = stencil_.offsets(d);
        if (list.shifts == nullptr || !problem.domain.periodic[d]) {
          for (int p = 0; p < n; ++p) offset[p] = particles[std::size_t{index[p]} * D + d] - x[d];
        } else {
          const ImageShift* shift = list.shifts + list.offsets[t];
          const Scalar period = problem.domain.period(d);
          for (int p = 0; p < n; ++p)
            offset[p] = (particles[std::size_t{index[p]} * D + d] - x[d]) + shift[p][d] * period;
        }
      }
    }

    const ShapeChoice& choice_;
    Stencil<Scalar, D> stencil_;
    std::unique_ptr<CompiledSolve<Scalar, D>> solve_, polynomial_;
    std::vector<Scalar> values_, on_monomials_;
    std::vector<double> actions_, largest_, turn_;
  };

  // What a block of targets is worked on with.
  struct Buffers {
    std::vector<LaneReport> reports;
    std::unique_ptr<void, void (*)(void*)> lanes;  // null where there are none
    Frames frames;
    Single single;

    Buffers(const ShapeChoice& choice, const LaneFunctions<Scalar>& functions)
        : lanes(functions.make ? functions.make(choice.tolerances) : nullptr, functions.destroy),
          single(choice) {}
  };

  // The frames of these targets; null where supports are balls.
  static const Frames* prepared(const ShapeProblem<Scalar>& problem, std::size_t begin,
                                std::size_t end, bool slopes, Buffers& buffers) {
    if (!problem.neighbours.tensor && !problem.neighbours.pair_tensor) return nullptr;
    buffers.frames.prepare(problem, begin, end, slopes);
    return &buffers.frames;
  }

  LaneTask<Scalar> lane_task(const ShapeProblem<Scalar>& problem, std::size_t begin,
                             std::size_t end, const Frames* frames, const ShapeRows<Scalar>& rows,
                             LaneReport* reports) const {
    const NeighbourListView<Scalar>& list = problem.neighbours;
    LaneTask<Scalar> task;
    for (int d = 0; d < D; ++d) {
      if (problem.domain.periodic[d]) task.period[d] = problem.domain.period(d);
    }
    task.particles = problem.particles.data();
    task.targets = problem.targets.data() + begin * D;
    task.offsets = list.offsets;
    task.indices = list.indices;
    task.shifts = list.shifts;
    task.support = list.support;
    task.pair_support = list.pair_support;
    task.support_factor = list.support_factor;
    task.particle_weights = problem.particle_weights;
    task.axis_scale = frames ? ShapeProblem<Scalar>::no_scale : problem.axis_scale;
    if (frames) {
      const std::int64_t first = list.offsets[begin];
      task.targets = frames->size(begin);
      task.local_offsets = frames->offset(first);
      task.pair_distances = frames->distance(first);
      task.pair_slopes = frames->slope(first);
    }
    task.weigh = weigh_;
    task.weight = choice_.weight.state();
    task.form = choice_.form;
    task.solver = choice_.solver;
    task.begin = begin;
    task.end = end;
    task.rows = rows;
    task.reports = reports;
    return task;
  }

  ShapeChoice choice_;
  LaneFunctions<Scalar> lanes_;
  mutable Pool<Buffers> buffers_;
  typename WeightFunction::Function<Scalar> weigh_;
  FitReport full_;  // on a target of the lanes, but for its numbers
};

}  // namespace recon::detail

namespace recon {

template <class Scalar>
std::unique_ptr<ShapeKernel<Scalar>> make_shape_kernel(int dimension, const ShapeChoice& choice) {
  switch (dimension) {
    case 1:
      return std::make_unique<detail::Kernel<Scalar, 1>>(choice);
    case 2:
      return std::make_unique<detail::Kernel<Scalar, 2>>(choice);
    case 3:
      return std::make_unique<detail::Kernel<Scalar, 3>>(choice);
    default:
      detail::throw_invalid("dimension", dimension, "must be 1, 2 or 3");
  }
}

}  // namespace recon
