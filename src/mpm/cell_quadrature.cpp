#include "mpm/cell_quadrature.hpp"

#include "mpm/add_point.hpp"
#include "recon/core/parallel.hpp"
#include "recon/grid/reconstruct_on_grid.hpp"

namespace recon::mpm {
namespace {

template <int D>
std::vector<double> particle_volumes(const Grid<D>& grid, const Particles<D>& particles) {
  std::vector<double> volume(grid.cell_count());
  for (std::size_t p = 0; p < particles.size(); ++p)
    volume[grid.cell_number(particles.x[p])] += particles.volume(p);
  return volume;
}

// The cell and all its neighbours within the grid hold particles.
template <int D>
bool is_full(const Grid<D>& grid, const std::vector<double>& volume, std::size_t cell) {
  std::array<int, D> at;
  for (int d = 0; d < D; ++d) {
    const auto cells = static_cast<std::size_t>(grid.cells(d));
    at[d] = static_cast<int>(cell % cells);
    cell /= cells;
  }
  int neighbours = 1;
  for (int d = 0; d < D; ++d) neighbours *= 3;
  for (int n = 0; n < neighbours; ++n) {
    std::size_t number = 0, stride = 1;
    bool in_grid = true;
    for (int d = 0, rest = n; d < D; ++d, rest /= 3) {
      const int index = at[d] + rest % 3 - 1;
      in_grid = in_grid && index >= 0 && index < grid.cells(d);
      number += stride * static_cast<std::size_t>(index);
      stride *= static_cast<std::size_t>(grid.cells(d));
    }
    if (in_grid && !(volume[number] > 0)) return false;
  }
  return true;
}

template <int D>
std::vector<double> fill_of(const Grid<D>& grid, const Particles<D>& particles) {
  const std::vector<double> volume = particle_volumes(grid, particles);
  std::vector<double> fill(volume.size());
  for (std::size_t c = 0; c < volume.size(); ++c)
    if (volume[c] > 0)
      fill[c] = is_full(grid, volume, c) ? 1 : std::min(1.0, volume[c] / std::pow(grid.h(), D));
  return fill;
}

// Over the cells, fitted at the centre of each, its only point (`cells`), or at the nodes, linear
// between them and integrated exactly (`nodal_cells`).
template <int D>
class CellQuadrature : public QuadraturePolicy<D> {
 public:
  using QuadraturePolicy<D>::QuadraturePolicy;

  FromParticles over_cells(const State<D>& s, const std::vector<Vector<D>>& b, Cells<D>& cells,
                           Nodes<D>& nodes) const override {
    const Grid<D>& grid = problem_.grid;
    const bool at_nodes = problem_.method.quadrature == Quadrature::nodal_cells;
    const QuadratureData<D> data(s.particles, b, false, problem_.threads);
    fit(data.field(), s.particles, at_nodes ? grid.nodes() : cell_centres(grid.nodes()),
        at_nodes ? Weight::cubic_b_spline : Weight::quadratic_b_spline, cells);
    cells.fill = fill_of(grid, s.particles);

    const CellPoints<D> points(grid, at_nodes ? 2 : 1);
    const LinearFunctions linear;
    LinearFunctions::Nodes<D> shape;
    std::vector<double> values(static_cast<std::size_t>(data.columns()));
    for (std::size_t c = 0; c < cells.fill.size(); ++c) {
      if (!(cells.fill[c] > 0)) continue;
      for (std::size_t g = 0; g < points.per_cell(); ++g) {
        linear.at(grid, points.at(c, g), shape);
        for (int k = 0; k < data.columns(); ++k) {
          double& value = values[static_cast<std::size_t>(k)];
          if (!at_nodes) {
            value = cells.values(static_cast<Eigen::Index>(c), k);
            continue;
          }
          value = 0;
          for (std::size_t n = 0; n < shape.size(); ++n)
            value += shape.S[n] * cells.values(shape.node[n], k);
        }
        add_point(shape, cells.fill[c] * points.volume(), values.data(), !b.empty(), false, nodes);
      }
    }
    return {.mass_and_force = false};
  }

 private:
  // Degrees above 2 want more particles than a quadratic spline sees.
  void fit(const FieldView<double>& field, const Particles<D>& particles,
           const StructuredGrid<double>& targets, Weight weight, Cells<D>& cells) const {
    const int degree = problem_.method.degree;
    auto made = reconstruct_on_grid(points_of(particles.x), {field}, targets,
                                    {.degree = degree,
                                     .weight = degree <= 2 ? weight : Weight::cubic_b_spline,
                                     .threads = problem_.threads});
    cells.fit = made.report();
    cells.values = std::move(made).values();
  }

  using QuadraturePolicy<D>::problem_;
};

}  // namespace

template <int D>
QuadratureData<D>::QuadratureData(const Particles<D>& particles, const std::vector<Vector<D>>& b,
                                  bool momentum, int threads)
    : columns_(1 + D * (D + 1) / 2 + (b.empty() ? 0 : D) + (momentum ? D : 0)) {
  data_.resize(particles.size() * static_cast<std::size_t>(columns_));
  parallel_blocks(particles.size(), 4096, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      double* out = data_.data() + p * static_cast<std::size_t>(columns_);
      const double density = particles.density(p);
      *out++ = density;
      for (int r = 0; r < D; ++r)
        for (int c = r; c < D; ++c) *out++ = particles.stress[p](r, c);
      for (int d = 0; d < D && !b.empty(); ++d) *out++ = b[p][d];
      for (int d = 0; d < D && momentum; ++d) *out++ = density * particles.v[p][d];
    }
  });
}

template <int D>
FieldView<double> QuadratureData<D>::field() const {
  return {data_.size() / static_cast<std::size_t>(columns_), columns_, data_.data(),
          columns_ * static_cast<std::ptrdiff_t>(sizeof(double)), sizeof(double)};
}

template <int D>
std::vector<double> full_cells(const Grid<D>& grid, const Particles<D>& particles) {
  const std::vector<double> volume = particle_volumes(grid, particles);
  std::vector<double> full(volume.size());
  for (std::size_t c = 0; c < volume.size(); ++c)
    full[c] = volume[c] > 0 && is_full(grid, volume, c) ? 1 : 0;
  return full;
}

template <int D>
std::unique_ptr<const QuadraturePolicy<D>> make_quadrature(const Problem<D>& problem) {
  if (is_cell(problem.method.quadrature)) return std::make_unique<CellQuadrature<D>>(problem);
  if (is_gauss(problem.method.quadrature)) return make_gauss_quadrature(problem);
  return std::make_unique<QuadraturePolicy<D>>(problem);
}

#define RECON_INSTANTIATE(D)                                                    \
  template class QuadratureData<D>;                                             \
  template std::vector<double> full_cells(const Grid<D>&, const Particles<D>&); \
  template std::unique_ptr<const QuadraturePolicy<D>> make_quadrature(const Problem<D>&);
RECON_DIMENSIONS(RECON_INSTANTIATE)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
