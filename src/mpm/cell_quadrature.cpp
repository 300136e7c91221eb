#include "mpm/cell_quadrature.hpp"

#include "recon/core/parallel.hpp"

namespace recon::mpm {
namespace {

// The part of each cell that holds material.
template <int D>
std::vector<double> fill_of(const Problem<D>& problem, const StructuredGrid<double>& centres) {
  const Grid<D>& grid = problem.grid;
  const Particles<D>& particles = problem.particles;
  std::vector<double> volume(centres.size());
  const auto number = [&](const std::array<int, D>& index) {
    std::size_t n = 0;
    for (int d = D - 1; d >= 0; --d) n = n * centres.counts[d] + static_cast<std::size_t>(index[d]);
    return n;
  };
  for (std::size_t p = 0; p < particles.size(); ++p) {
    std::array<int, D> index;
    for (int d = 0; d < D; ++d) index[d] = grid.cell(particles.x[p][d], d);
    volume[number(index)] += particles.volume(p);
  }
  std::vector<double> fill(volume.size());
  for (std::size_t c = 0; c < volume.size(); ++c) {
    if (volume[c] == 0) continue;
    const auto at = centres.index(c);
    bool inside = true;
    int neighbours = 1;
    for (int d = 0; d < D; ++d) neighbours *= 3;
    for (int n = 0; n < neighbours && inside; ++n) {
      std::array<int, D> index;
      bool in_grid = true;
      for (int d = 0, rest = n; d < D; ++d, rest /= 3) {
        index[d] = static_cast<int>(at[d]) + rest % 3 - 1;
        in_grid = in_grid && index[d] >= 0 && index[d] < grid.cells(d);
      }
      inside = !in_grid || volume[number(index)] > 0;
    }
    fill[c] = inside ? 1 : std::min(1.0, volume[c] / std::pow(grid.h(), D));
  }
  return fill;
}

}  // namespace

template <int D>
void fit_cells(const Problem<D>& problem, const std::vector<Vector<D>>& b, Cells<D>& cells) {
  const Particles<D>& particles = problem.particles;
  constexpr int stresses = D * (D + 1) / 2;
  const int columns = 1 + stresses + (b.empty() ? 0 : D);
  std::vector<double> data(particles.size() * static_cast<std::size_t>(columns));
  parallel_blocks(particles.size(), 4096, problem.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      double* out = data.data() + p * static_cast<std::size_t>(columns);
      *out++ = particles.density(p);
      for (int r = 0; r < D; ++r)
        for (int c = r; c < D; ++c) *out++ = particles.stress[p](r, c);
      for (int d = 0; d < D && !b.empty(); ++d) *out++ = b[p][d];
    }
  });
  const FieldView<double> field(particles.size(), columns, data.data(),
                                columns * static_cast<std::ptrdiff_t>(sizeof(double)),
                                sizeof(double));
  const StructuredGrid<double> centres = cell_centres(problem.grid.nodes());
  auto fit = reconstruct_on_grid(points_of(particles.x), {field}, centres,
                                 {.degree = problem.method.degree,
                                  .weight = Weight::quadratic_b_spline,
                                  .threads = problem.threads});
  cells.fit = fit.report();
  cells.fill = fill_of(problem, centres);
  cells.values = std::move(fit).values();
}

template <int D>
void integrate_cells(const Grid<D>& grid, const Cells<D>& cells, Nodes<D>& nodes) {
  constexpr int corner_count = 1 << D;
  constexpr int stresses = D * (D + 1) / 2;
  const bool body_force = cells.values.cols() > 1 + stresses;
  const StructuredGrid<double> centres = cell_centres(grid.nodes());
  const double volume = std::pow(grid.h(), D), slope = 2 / (grid.h() * corner_count);
  for (std::size_t c = 0; c < cells.fill.size(); ++c) {
    if (!(cells.fill[c] > 0)) continue;
    const auto row = cells.values.row(static_cast<Eigen::Index>(c));
    const double part = cells.fill[c] * volume;
    Matrix<D> stress;
    for (int r = 0, k = 1; r < D; ++r)
      for (int s = r; s < D; ++s, ++k) stress(r, s) = stress(s, r) = row[k];
    Vector<D> push = Vector<D>::Zero();
    for (int d = 0; d < D && body_force; ++d) push[d] = row[0] * row[1 + stresses + d];
    const auto at = centres.index(c);
    for (int a = 0; a < corner_count; ++a) {
      std::array<int, D> index;
      Vector<D> gradient;
      for (int d = 0; d < D; ++d) {
        index[d] = static_cast<int>(at[d]) + (a >> d & 1);
        gradient[d] = a >> d & 1 ? slope : -slope;
      }
      const std::uint32_t i = grid.number(index);
      nodes.mass[i] += part * row[0] / corner_count;
      nodes.force[i] += part * (push / corner_count - stress * gradient);
    }
  }
}

#define RECON_INSTANTIATE(D)                                                            \
  template void fit_cells(const Problem<D>&, const std::vector<Vector<D>>&, Cells<D>&); \
  template void integrate_cells(const Grid<D>&, const Cells<D>&, Nodes<D>&);
RECON_INSTANTIATE(1)
RECON_INSTANTIATE(2)
RECON_INSTANTIATE(3)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
