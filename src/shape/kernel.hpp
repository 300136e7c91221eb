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
    if (buffers->lanes)
      lanes_.run(buffers->lanes.get(), lane_task(problem, begin, end, rows, reports.data()));

    for (std::size_t i = begin; i < end; ++i) {
      const LaneReport& lane = reports[i - begin];
      FitReport report = full_;
      if (lane.done)
        set_numbers(lane.numbers, report);
      else
        report = buffers->single.evaluate(problem, i, rows);
      if (rows.report) rows.report[i] = report;
    }
  }

  void evaluate(const ShapeProblem<Scalar>& problem, std::size_t begin, std::size_t end,
                const FunctionalRows<Scalar>& rows) const override {
    const auto buffers = buffers_.lend([&] { return std::make_unique<Buffers>(choice_, lanes_); });
    for (std::size_t i = begin; i < end; ++i) buffers->single.evaluate(problem, i, rows);
  }

  void forget_buffers() const override { buffers_.clear(); }

 private:
  using Powers = std::array<int, max_dimension>;

  // Treats one target after another.
  class Single {
   public:
    explicit Single(const ShapeChoice& choice)
        : choice_(choice),
          solve_(make_solve<Scalar, D>(choice.degree, choice.solver, choice.tolerances)),
          polynomial_(
              make_solve<Scalar, D>(choice.degree, Solver::gram_schmidt, choice.tolerances)) {}

    FitReport evaluate(const ShapeProblem<Scalar>& problem, std::size_t t,
                       const ShapeRows<Scalar>& rows) {
      constexpr int seconds = D * (D + 1) / 2;
      const std::int64_t row = problem.neighbours.offsets[t],
                         row_end = problem.neighbours.offsets[t + 1];
      if (rows.value) std::fill(rows.value + row, rows.value + row_end, Scalar(0));
      if (rows.gradient) std::fill(rows.gradient + row * D, rows.gradient + row_end * D, Scalar(0));
      if (rows.hessian)
        std::fill(rows.hessian + row * seconds, rows.hessian + row_end * seconds, Scalar(0));

      gather(problem, t, rows.gradient && rows.kind == Derivative::exact);
      const LocalCloud<Scalar, D> cloud = stencil_.cloud();
      const FitReport report = solve_->fit(cloud);
      if (report.rank == 0) return report;

      const int n = cloud.size;
      values_.resize(static_cast<std::size_t>(n) * jet_size(D));
      const auto out =
          ShapeArrays<Scalar, D>::in(values_.data(), n, rows.kind, rows.gradient, rows.hessian);
      solve_->shape_functions(cloud, out);

      for (int p = 0; p < n; ++p) {
        const std::int64_t entry = row + stencil_.place(p);
        if (rows.value) rows.value[entry] = out.value[p];
        for (int d = 0; d < D && rows.gradient; ++d)
          rows.gradient[entry * D + d] = out.gradient[d][p] * problem.axis_scale[d];
        int i = 0;
        for (int a = 0; a < D && rows.hessian; ++a)
          for (int b = a; b < D; ++b, ++i)
            rows.hessian[entry * seconds + i] =
                out.hessian[i][p] * problem.axis_scale[a] * problem.axis_scale[b];
      }
      return report;
    }

    void evaluate(const ShapeProblem<Scalar>& problem, std::size_t t,
                  const FunctionalRows<Scalar>& rows) {
      const auto numbers = static_cast<std::size_t>(rows.numbers);
      Scalar* const values = rows.value + problem.neighbours.offsets[t] * rows.numbers;
      std::fill_n(values, problem.neighbours.count(t) * rows.numbers, Scalar(0));
      gather(problem, t, false);
      const LocalCloud<Scalar, D> cloud = stencil_.cloud();
      if (polynomial_->fit(cloud).rank == 0) return;

      act(problem, t, rows);
      values_.resize(static_cast<std::size_t>(cloud.size));
      for (std::size_t i = 0; i < numbers; ++i) {
        polynomial_->shape_functions_of(on_monomials_.data() + i * jets(), values_.data());
        for (int p = 0; p < cloud.size; ++p)
          values[static_cast<std::size_t>(stencil_.place(p)) * numbers + i] = values_[p];
      }
    }

   private:
    // The number of Taylor coefficients of the polynomials.
    std::size_t jets() const {
      return static_cast<std::size_t>(monomial_count(D, std::max(choice_.degree, 2)));
    }

    // Sets on_monomials_[i * jets() + a] to what functional i makes of monomial a in xi.
    void act(const ShapeProblem<Scalar>& problem, std::size_t t,
             const FunctionalRows<Scalar>& rows) {
      const auto numbers = static_cast<std::size_t>(rows.numbers);
      const double rho = static_cast<double>(problem.neighbours.support[t]);
      on_monomials_.assign(numbers * jets(), Scalar(0));
      action_.resize(numbers);
      largest_.assign(numbers, 0);
      for (int a = 0; a < monomial_count(D, choice_.degree); ++a) {
        Powers powers{};
        for (int d = 0; d < D; ++d) powers[d] = Monomials<D, max_compiled_degree>::exponents[a][d];
        rows.action(t, powers, action_);
        for (std::size_t i = 0; i < numbers; ++i) {
          double scaled = action_[i];
          for (int d = 0; d < D; ++d)
            for (int n = 0; n < powers[d]; ++n)
              scaled *= static_cast<double>(problem.axis_scale[d]) / rho;
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

    void gather(const ShapeProblem<Scalar>& problem, std::size_t t, bool slopes) {
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
      if (problem.particle_weights) {
        Scalar* weights = stencil_.particle_weights();
        for (int p = 0; p < n; ++p) weights[p] = problem.particle_weights[index[p]];
      }
      if (list.pair_support)
        std::copy_n(list.pair_support + list.offsets[t], n, stencil_.pair_supports());
      stencil_.weigh(choice_.weight, choice_.form, slopes, list.support_factor);
    }

    const ShapeChoice& choice_;
    Stencil<Scalar, D> stencil_;
    std::unique_ptr<CompiledSolve<Scalar, D>> solve_, polynomial_;
    std::vector<Scalar> values_, on_monomials_;
    std::vector<double> action_, largest_;
  };

  // What a block of targets is worked on with.
  struct Buffers {
    std::vector<LaneReport> reports;
    std::unique_ptr<void, void (*)(void*)> lanes;  // null where there are none
    Single single;

    Buffers(const ShapeChoice& choice, const LaneFunctions<Scalar>& functions)
        : lanes(functions.make ? functions.make(choice.tolerances) : nullptr, functions.destroy),
          single(choice) {}
  };

  LaneTask<Scalar> lane_task(const ShapeProblem<Scalar>& problem, std::size_t begin,
                             std::size_t end, const ShapeRows<Scalar>& rows,
                             LaneReport* reports) const {
    const NeighbourListView<Scalar>& list = problem.neighbours;
    LaneTask<Scalar> task;
    for (int d = 0; d < D; ++d) {
      if (problem.domain.periodic[d]) task.period[d] = problem.domain.period(d);
    }
    task.particles = problem.particles.data();
    task.targets = problem.targets.data();
    task.offsets = list.offsets;
    task.indices = list.indices;
    task.shifts = list.shifts;
    task.support = list.support;
    task.pair_support = list.pair_support;
    task.support_factor = list.support_factor;
    task.particle_weights = problem.particle_weights;
    task.axis_scale = problem.axis_scale;
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
