// The shape-function kernel for one dimension; compiled once per scalar and dimension
// (kernel_*.cpp).
#pragma once

#include <algorithm>
#include <vector>

#include "recon/local_solve/local_solve.hpp"
#include "recon/shape/shape_kernel.hpp"
#include "recon/shape/stencil.hpp"

namespace recon::detail {

template <class Scalar, int D, int R>
class Kernel final : public ShapeKernel<Scalar> {
 public:
  explicit Kernel(const ShapeChoice& choice) : choice_(choice) {}

  void evaluate(const ShapeProblem<Scalar>& problem, std::size_t begin, std::size_t end,
                const ShapeRows<Scalar>& rows) const override {
    constexpr int seconds = D * (D + 1) / 2;
    Stencil<Scalar, D> stencil;
    LocalSolve<Scalar, Monomials<D, R>> solve(choice_.solver, choice_.tolerances);
    std::vector<Scalar> values;
    const bool slopes = rows.gradient && rows.kind == Derivative::exact;

    for (std::size_t t = begin; t < end; ++t) {
      const std::int64_t row = problem.neighbours.offsets[t],
                         row_end = problem.neighbours.offsets[t + 1];
      if (rows.value) std::fill(rows.value + row, rows.value + row_end, Scalar(0));
      if (rows.gradient) std::fill(rows.gradient + row * D, rows.gradient + row_end * D, Scalar(0));
      if (rows.hessian)
        std::fill(rows.hessian + row * seconds, rows.hessian + row_end * seconds, Scalar(0));

      gather(problem, t, slopes, stencil);
      const LocalCloud<Scalar, D> cloud = stencil.cloud();
      const FitReport report = solve.fit(cloud);
      if (rows.report) rows.report[t] = report;
      if (report.rank == 0) continue;

      const int n = cloud.size;
      values.resize(static_cast<std::size_t>(n) * jet_size(D));
      const auto out =
          ShapeArrays<Scalar, D>::in(values.data(), n, rows.kind, rows.gradient, rows.hessian);
      solve.shape_functions(cloud, out);

      for (int p = 0; p < n; ++p) {
        const std::int64_t entry = row + stencil.place(p);
        if (rows.value) rows.value[entry] = out.value[p];
        for (int d = 0; d < D && rows.gradient; ++d)
          rows.gradient[entry * D + d] = out.gradient[d][p] * problem.axis_scale[d];
        int i = 0;
        for (int a = 0; a < D && rows.hessian; ++a)
          for (int b = a; b < D; ++b, ++i)
            rows.hessian[entry * seconds + i] =
                out.hessian[i][p] * problem.axis_scale[a] * problem.axis_scale[b];
      }
    }
  }

 private:
  void gather(const ShapeProblem<Scalar>& problem, std::size_t t, bool slopes,
              Stencil<Scalar, D>& stencil) const {
    const auto& list = problem.neighbours;
    const std::array<Scalar, D> x = problem.targets.template point<D>(t);
    const ParticleIndex* index = list.indices.data() + list.offsets[t];
    stencil.start(x, list.support[t], static_cast<int>(list.count(t)));
    for (int d = 0; d < D; ++d) {
      const Scalar* axis = problem.particles.axis(d).data();
      if (list.shifts.empty() || !problem.domain.periodic[d]) {
        stencil.set_offsets(d, [&](int p) { return axis[index[p]] - x[d]; });
      } else {
        const ImageShift* shift = list.shifts.data() + list.offsets[t];
        const Scalar period = problem.domain.period(d);
        stencil.set_offsets(d,
                            [&](int p) { return (axis[index[p]] - x[d]) + shift[p][d] * period; });
      }
    }
    stencil.weigh(choice_.weight, choice_.form, slopes, problem.support_factor);
  }

  ShapeChoice choice_;
};

template <class Scalar, int D>
std::unique_ptr<ShapeKernel<Scalar>> make_kernel(const ShapeChoice& choice) {
  switch (choice.degree) {
    case 0:
      return std::make_unique<Kernel<Scalar, D, 0>>(choice);
    case 1:
      return std::make_unique<Kernel<Scalar, D, 1>>(choice);
    case 2:
      return std::make_unique<Kernel<Scalar, D, 2>>(choice);
    case 3:
      return std::make_unique<Kernel<Scalar, D, 3>>(choice);
    case 4:
      return std::make_unique<Kernel<Scalar, D, 4>>(choice);
    default:
      throw_invalid("degree", choice.degree, "must be 0 to 4");
  }
}

}  // namespace recon::detail
