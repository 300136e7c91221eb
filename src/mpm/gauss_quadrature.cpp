// Quadrature at Gauss points of reconstructed density, momentum and stress in the cells that are
// full; in all other cells the particles are the quadrature points.
//
//   taylor_cells  in each cell u = a_1 + sum_k a_k psi_k with psi of mean zero, of xi = (x - x_c) /
//                 (h / 2): xi_d, xi_d^2 / 2 - 1/6 and xi_d xi_e. For density and momentum a_1 is
//                 the sum of the particles' masses and momenta over the volume of the cell, so that
//                 the integral is theirs whatever the rest; a_k by least squares of u_p - a_1. For
//                 the stress all by least squares (Wobbes, Moller, Galavi, Vuik 2018). Without the
//                 quadratic psi where a cell holds too few particles for them
//   gauss_cells   moving least squares at each Gauss point, cubic B-spline of support 2 h
//                 (Tran, Wobbes, Solowski, Moller, Vuik 2019)
#include <Eigen/QR>

#include "core/counting_sort.hpp"
#include "mpm/add_point.hpp"
#include "mpm/cell_quadrature.hpp"

namespace recon::mpm {
namespace {

// values(c, g) of cell c at Gauss point g: a row of numbers, one for each column of the data.
template <int D>
class GaussFits {
 public:
  GaussFits(const Problem<D>& problem, const Particles<D>& particles, const QuadratureData<D>& data,
            const CellPoints<D>& points) {
    for (std::size_t g = 0; g < points.per_cell(); ++g) {
      StructuredGrid<double> targets = cell_centres(problem.grid.nodes());
      for (int d = 0; d < D; ++d) targets.origin[d] = problem.grid.lower()[d] + points.place(g)[d];
      fits_.push_back(reconstruct_on_grid(points_of(particles.x), {data.field()}, targets,
                                          {.degree = problem.method.degree,
                                           .weight = Weight::cubic_b_spline,
                                           .threads = problem.threads}));
    }
  }
  Eigen::RowVectorXd operator()(std::size_t c, std::size_t g) const {
    return fits_[g].values().row(static_cast<Eigen::Index>(c));
  }

 private:
  std::vector<GridReconstruction> fits_;
};

template <int D>
class TaylorFits {
 public:
  TaylorFits(const Problem<D>& problem, const Particles<D>& particles,
             const QuadratureData<D>& data, const CellPoints<D>& points, bool body_force)
      : grid_(problem.grid), particles_(particles), data_(data), points_(points) {
    const std::span<std::uint32_t> cell = by_cell_.keys(particles.size());
    for (std::size_t p = 0; p < particles.size(); ++p)
      cell[p] = static_cast<std::uint32_t>(problem.grid.cell_number(particles.x[p]));
    by_cell_.sort(problem.grid.cell_count(), problem.threads);
    first_momentum_ = 1 + D * (D + 1) / 2 + (body_force ? D : 0);
  }

  Eigen::RowVectorXd operator()(std::size_t c, std::size_t g) {
    if (c != cell_) solve(c);
    return psi(points_.at(c, g)) * coefficients_;
  }

 private:
  static constexpr int linear = 1 + D, quadratic = linear + D * (D + 1) / 2;

  Eigen::RowVectorXd psi(const Vector<D>& x) const {
    const Vector<D> xi = (x - centre_) / (grid_.h() / 2);
    Eigen::RowVectorXd row(coefficients_.rows());
    row[0] = 1;
    int k = 1;
    for (int d = 0; d < D && k < row.size(); ++d) row[k++] = xi[d];
    for (int d = 0; d < D && k < row.size(); ++d)
      for (int e = d; e < D; ++e) row[k++] = d == e ? xi[d] * xi[d] / 2 - 1.0 / 6 : xi[d] * xi[e];
    return row;
  }

  void solve(std::size_t c) {
    cell_ = c;
    const auto numbers = by_cell_.order().subspan(by_cell_.first()[c],
                                                  by_cell_.first()[c + 1] - by_cell_.first()[c]);
    const auto count = static_cast<int>(numbers.size());
    const int terms = count > quadratic ? quadratic : count > linear ? linear : 1;
    coefficients_.setZero(terms, data_.columns());
    centre_.setZero();
    for (std::size_t g = 0; g < points_.per_cell(); ++g)
      centre_ += points_.at(c, g) / static_cast<double>(points_.per_cell());

    Eigen::MatrixXd A(count, terms), u(count, data_.columns());
    const double volume = std::pow(grid_.h(), D);
    Eigen::RowVectorXd mean = Eigen::RowVectorXd::Zero(data_.columns());
    for (int k = 0; k < count; ++k) {
      const std::size_t p = numbers[k];
      A.row(k) = psi(particles_.x[p]);
      u.row(k) = Eigen::Map<const Eigen::RowVectorXd>(data_.row(p), data_.columns());
      mean += particles_.volume(p) / volume * u.row(k);
    }
    const auto is_conserved = [&](int column) { return column == 0 || column >= first_momentum_; };
    Eigen::MatrixXd rest = u;
    for (int column = 0; column < data_.columns(); ++column)
      if (is_conserved(column)) rest.col(column).array() -= mean[column];
    const Eigen::MatrixXd all = A.completeOrthogonalDecomposition().solve(rest);
    Eigen::MatrixXd shape = Eigen::MatrixXd::Zero(terms, data_.columns());
    if (terms > 1)
      shape.bottomRows(terms - 1) =
          A.rightCols(terms - 1).completeOrthogonalDecomposition().solve(rest);
    shape.row(0) = mean;
    for (int column = 0; column < data_.columns(); ++column) {
      const Eigen::MatrixXd& from = is_conserved(column) ? shape : all;
      coefficients_.col(column) = from.col(column);
    }
  }

  const Grid<D>& grid_;
  const Particles<D>& particles_;
  const QuadratureData<D>& data_;
  const CellPoints<D>& points_;
  recon::detail::CountingSort by_cell_;
  int first_momentum_;
  std::size_t cell_ = static_cast<std::size_t>(-1);
  Vector<D> centre_;
  Eigen::MatrixXd coefficients_;  // a row for each function
};

template <int D>
class GaussQuadrature : public QuadraturePolicy<D> {
 public:
  using QuadraturePolicy<D>::QuadraturePolicy;

  FromParticles over_cells(const State<D>& s, const std::vector<Vector<D>>& b, Cells<D>& cells,
                           Nodes<D>& nodes) const override {
    const Particles<D>& particles = s.particles;
    cells.fill = full_cells(problem_.grid, particles);
    const QuadratureData<D> data(particles, b, true, problem_.threads);
    const CellPoints<D> points(problem_.grid, 2);
    if (problem_.method.quadrature == Quadrature::taylor_cells)
      integrate(TaylorFits<D>(this->problem_, particles, data, points, !b.empty()), points,
                !b.empty(), cells, nodes);
    else
      integrate(GaussFits<D>(this->problem_, particles, data, points), points, !b.empty(), cells,
                nodes);
    return {.full = &cells.fill};
  }

 private:
  template <class Values>
  void integrate(Values&& values, const CellPoints<D>& points, bool body_force,
                 const Cells<D>& cells, Nodes<D>& nodes) const {
    const Problem<D>& problem = this->problem_;
    const bool consistent = problem.method.mass == MassMatrix::consistent;
    with_shape(problem.method, [&](auto shape_of) {
      if constexpr (is_product<D, decltype(shape_of)>) {
        typename decltype(shape_of)::template Nodes<D> shape;
        for (std::size_t c = 0; c < cells.fill.size(); ++c) {
          if (!(cells.fill[c] > 0)) continue;
          for (std::size_t g = 0; g < points.per_cell(); ++g) {
            shape_of.functions.at(problem.grid, points.at(c, g), shape);
            const Eigen::RowVectorXd row = values(c, g);
            add_point(shape, points.volume(), row.data(), body_force, true, nodes);
            if (consistent) add_mass(shape, points.volume() * row[0], nodes.mass_entries);
          }
        }
      }
    });
  }

  using QuadraturePolicy<D>::problem_;
};

}  // namespace

template <int D>
std::unique_ptr<const QuadraturePolicy<D>> make_gauss_quadrature(const Problem<D>& problem) {
  return std::make_unique<GaussQuadrature<D>>(problem);
}

#define RECON_INSTANTIATE(D) \
  template std::unique_ptr<const QuadraturePolicy<D>> make_gauss_quadrature(const Problem<D>&);
RECON_DIMENSIONS(RECON_INSTANTIATE)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
