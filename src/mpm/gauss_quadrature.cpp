#include "mpm/gauss_quadrature.hpp"

#include <Eigen/QR>

#include "core/counting_sort.hpp"
#include "mpm/add_point.hpp"

namespace recon::mpm {
namespace {

// values(c, g) of cell c at Gauss point g: a row of numbers, one for each column of the data.
template <int D>
class GaussFits {
 public:
  GaussFits(const Problem<D>& problem, const QuadratureData<D>& data, const CellPoints<D>& points) {
    for (std::size_t g = 0; g < points.per_cell(); ++g) {
      StructuredGrid<double> targets = cell_centres(problem.grid.nodes());
      for (int d = 0; d < D; ++d) targets.origin[d] = problem.grid.lower()[d] + points.place(g)[d];
      fits_.push_back(reconstruct_on_grid(points_of(problem.particles.x), {data.field()}, targets,
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
  TaylorFits(const Problem<D>& problem, const QuadratureData<D>& data, const CellPoints<D>& points,
             bool body_force)
      : problem_(problem), data_(data), points_(points) {
    const Particles<D>& particles = problem.particles;
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
    const Vector<D> xi = (x - centre_) / (problem_.grid.h() / 2);
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
    const double volume = std::pow(problem_.grid.h(), D);
    Eigen::RowVectorXd mean = Eigen::RowVectorXd::Zero(data_.columns());
    for (int k = 0; k < count; ++k) {
      const std::size_t p = numbers[k];
      A.row(k) = psi(problem_.particles.x[p]);
      u.row(k) = Eigen::Map<const Eigen::RowVectorXd>(data_.row(p), data_.columns());
      mean += problem_.particles.volume(p) / volume * u.row(k);
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

  const Problem<D>& problem_;
  const QuadratureData<D>& data_;
  const CellPoints<D>& points_;
  recon::detail::CountingSort by_cell_;
  int first_momentum_;
  std::size_t cell_ = static_cast<std::size_t>(-1);
  Vector<D> centre_;
  Eigen::MatrixXd coefficients_;  // a row for each function
};

}  // namespace

template <int D>
void integrate_gauss(const Problem<D>& problem, const std::vector<Vector<D>>& b,
                     const std::vector<double>& full, Nodes<D>& nodes, MassEntries* entries) {
  const Grid<D>& grid = problem.grid;
  const QuadratureData<D> data(problem, b, true);
  const CellPoints<D> points(grid, 2);
  const auto integrate = [&](auto&& values) {
    with_shape(problem.method, [&](auto shape_of) {
      if constexpr (is_product<D, decltype(shape_of)>) {
        typename decltype(shape_of)::template Nodes<D> shape;
        for (std::size_t c = 0; c < full.size(); ++c) {
          if (!(full[c] > 0)) continue;
          for (std::size_t g = 0; g < points.per_cell(); ++g) {
            shape_of.functions.at(grid, points.at(c, g), shape);
            const Eigen::RowVectorXd row = values(c, g);
            add_point(shape, points.volume(), row.data(), !b.empty(), true, nodes);
            if (entries) add_mass(shape, points.volume() * row[0], *entries);
          }
        }
      }
    });
  };
  if (problem.method.quadrature == Quadrature::taylor_cells)
    integrate(TaylorFits<D>(problem, data, points, !b.empty()));
  else
    integrate(GaussFits<D>(problem, data, points));
}

template void integrate_gauss(const Problem<1>&, const std::vector<Vector<1>>&,
                              const std::vector<double>&, Nodes<1>&, MassEntries*);
template void integrate_gauss(const Problem<2>&, const std::vector<Vector<2>>&,
                              const std::vector<double>&, Nodes<2>&, MassEntries*);
template void integrate_gauss(const Problem<3>&, const std::vector<Vector<3>>&,
                              const std::vector<double>&, Nodes<3>&, MassEntries*);

}  // namespace recon::mpm
