// Formulas and algorithms of Gong (2015) that have to be corrected, as printed and as it must be.
//
// The printed form is written out beside the corrected one: the tests say why recon computes
// what it computes.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <vector>

#include "recon/basis/monomials.hpp"
#include "recon/points/generate.hpp"
#include "recon/recon.hpp"

namespace recon {
namespace {

double weight_at(Weight weight, double q) {
  double w;
  WeightFunction(weight).evaluate(&q, &w, nullptr, 1);
  return w;
}

// phi_p for all points at one target: a row of the reconstruction applied to unit data.
template <class Points>
Eigen::RowVectorXd shape_functions(const Points& points, const Points& target,
                                   const Options& options) {
  const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(points.size(), points.size());
  return reconstruct(points_of(points), points_of(target), options).apply(field_of(unit)).row(0);
}

// (3.8): phi_p = w_p b(x - x_p)^T M^-1 b(...). With b(x - x_p) in the last place, as printed, the
// sum over p is the trace of M^-1 M: the number of terms N_r. With b(0) it is 1.
template <int D, int R>
void expect_b_of_zero(std::uint64_t seed) {
  using Terms = Monomials<D, R>;
  using Vector = Eigen::Matrix<double, Terms::size, 1>;
  using Matrix = Eigen::Matrix<double, Terms::size, Terms::size>;
  const auto points = random_points<double, D>(80, seed);
  const PointList<double, D> target{random_points<double, D>(1, seed + 1000)};
  constexpr double rho = 0.6;
  const auto b = [](const std::array<double, D>& x) {
    Vector values;
    Terms::evaluate(x, values.data());
    return values;
  };
  std::vector<Vector> terms;
  std::vector<double> w;
  Matrix moments = Matrix::Zero();
  for (const auto& p : points) {
    std::array<double, D> offset;
    double q2 = 0;
    for (int d = 0; d < D; ++d) {
      offset[d] = (target[0][d] - p[d]) / rho;
      q2 += offset[d] * offset[d];
    }
    terms.push_back(b(offset));
    w.push_back(weight_at(Weight::cubic_b_spline, std::sqrt(q2)));
    moments += w.back() * terms.back() * terms.back().transpose();
  }
  const Eigen::LDLT<Matrix> inverse(moments);
  const Eigen::RowVectorXd phi =
      shape_functions(points, target, {.degree = R, .neighbours = Radius{rho}});
  double sum = 0, printed_sum = 0;
  for (std::size_t p = 0; p < points.size(); ++p) {
    const double right = w[p] * terms[p].dot(inverse.solve(b(std::array<double, D>{})));
    EXPECT_NEAR(right, phi[p], 1e-13 / inverse.rcond() * phi.cwiseAbs().maxCoeff());
    sum += right;
    printed_sum += w[p] * terms[p].dot(inverse.solve(terms[p]));
  }
  EXPECT_NEAR(sum, 1, 1e-15 / inverse.rcond());
  EXPECT_NEAR(phi.sum(), 1, 1e-14);
  EXPECT_NEAR(printed_sum, Terms::size, 1e-14 / inverse.rcond());
}

TEST(Gong2015Equation38, NeedsTheBasisAtZero) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    expect_b_of_zero<1, 0>(seed);
    expect_b_of_zero<1, 1>(seed);
    expect_b_of_zero<1, 2>(seed);
    expect_b_of_zero<2, 1>(seed);
    expect_b_of_zero<2, 2>(seed);
    expect_b_of_zero<3, 1>(seed);
  }
}

// (3.14): with B = [w_1 P(x_1), w_2 P(x_2), ...] the fit is P(x)^T M^-1 B U. The sum over p of
// these columns, as printed, knows no data: P(x)^T M^-1 sum_p w_p P(x_p) = 1 whatever U is.
TEST(Gong2015Equation314, HasAColumnForEachParticle) {
  const auto points = random_points<double, 1>(20, 5);
  const PointList<double, 1> target{{0.4}};
  constexpr double rho = 0.5;
  const Eigen::RowVectorXd phi =
      shape_functions(points, target, {.degree = 1, .neighbours = Radius{rho}});
  Eigen::Matrix2d M = Eigen::Matrix2d::Zero();
  Eigen::Matrix2Xd B(2, points.size());
  for (std::size_t p = 0; p < points.size(); ++p) {
    const Eigen::Vector2d P(1, points[p][0]);
    B.col(p) = weight_at(Weight::cubic_b_spline, std::abs(0.4 - points[p][0]) / rho) * P;
    M += B.col(p) * P.transpose();
  }
  const Eigen::RowVector2d row = Eigen::RowVector2d(1, 0.4) * M.inverse();
  EXPECT_LE((row * B - phi).cwiseAbs().maxCoeff(), 1e-13);
  const double printed = row * B.rowwise().sum();
  EXPECT_NEAR(printed, 1, 1e-13);
}

// (3.19): the entry (2, 1) of the first matrix is x^1 of its particle. With x^2, as printed, M has
// no symmetry, and the fit misses linear functions.
TEST(Gong2015Equation319, IsSymmetric) {
  const auto points = random_points<double, 2>(12, 6);
  const Eigen::Vector3d here(1, 0.45, 0.55);
  const auto fitted = [&](bool as_printed) {
    Eigen::Matrix3d M = Eigen::Matrix3d::Zero();
    Eigen::Vector3d B = Eigen::Vector3d::Zero();
    for (std::size_t p = 0; p < points.size(); ++p) {
      const Eigen::Vector3d P(1, points[p][0], points[p][1]);
      const double w = weight_at(Weight::cubic_b_spline, std::abs(here[1] - P[1])) *
                       weight_at(Weight::cubic_b_spline, std::abs(here[2] - P[2]));
      Eigen::Matrix3d of_particle = P * P.transpose();
      if (as_printed && p == 0) of_particle(1, 0) = P[2];
      M += w * of_particle;
      B += w * P * (1 + P[1] - 2 * P[2]);
    }
    return here.dot(M.inverse() * B);
  };
  const double exact = 1 + here[1] - 2 * here[2];
  EXPECT_NEAR(fitted(false), exact, 1e-13);
  EXPECT_GT(std::abs(fitted(true) - exact), 1e-3);
}

// (5.1), (5.2) and Tran et al. (10): recon's B-splines of radius 2 h and 3 h / 2.
// Printed: 3 / (2 h).
TEST(Gong2015Weights, AreTheCardinalSplines) {
  constexpr double h = 0.37;
  for (int i = -400; i <= 400; ++i) {
    const double x = i * h / 160;  // -2.5 h to 2.5 h
    const double r = std::abs(x) / h, r2 = r / 2;
    const double cubic = r2 <= 0.5 ? 2.0 / 3 - 4 * r2 * r2 + 4 * r2 * r2 * r2
                         : r2 <= 1 ? 4.0 / 3 - 4 * r2 + 4 * r2 * r2 - 4.0 / 3 * r2 * r2 * r2
                                   : 0;
    const double quadratic = r <= 0.5 ? 0.75 - r * r : r <= 1.5 ? (1.5 - r) * (1.5 - r) / 2 : 0;
    EXPECT_NEAR(weight_at(Weight::cubic_b_spline, std::abs(x) / (2 * h)), cubic, 2e-15);
    EXPECT_NEAR(weight_at(Weight::quadratic_b_spline, std::abs(x) / (1.5 * h)), quadratic, 2e-15);
  }
  EXPECT_GT(weight_at(Weight::quadratic_b_spline, 1.499 / 1.5), 0);
  EXPECT_EQ(weight_at(Weight::quadratic_b_spline, 1), 0);
  // (10) of Tran et al. has -2 x where it must have -2 |x|: on the left it would jump at x = -l_e.
  const auto printed = [](double x) {
    return 4.0 / 3 - 2 * x + x * x - std::pow(std::abs(x), 3) / 6;
  };
  EXPECT_NEAR(printed(1.5), weight_at(Weight::cubic_b_spline, 0.75), 1e-15);
  EXPECT_NEAR(printed(-1.5), weight_at(Weight::cubic_b_spline, 0.75) + 6, 1e-14);
}

// The four pieces of the cubic spline in section 5.4, as a function of the natural coordinate.
// Printed: 3/2 for 2/3 in the second.
std::array<double, 4> cubic_pieces(double xi, double second_constant = 2.0 / 3) {
  return {(1 - xi) * (1 - xi) * (1 - xi) / 6, second_constant + xi * xi * (-1 + 0.5 * xi),
          1.0 / 6 + xi * (0.5 + xi * (0.5 - 0.5 * xi)), xi * xi * xi / 6};
}

TEST(Gong2015Weights, PiecesOfTheCubicSplineSumToOne) {
  for (int i = 0; i <= 100; ++i) {
    const double xi = i / 100.0;
    const auto w = cubic_pieces(xi), printed = cubic_pieces(xi, 1.5);
    EXPECT_NEAR(w[0] + w[1] + w[2] + w[3], 1, 4e-16);
    EXPECT_NEAR(printed[0] + printed[1] + printed[2] + printed[3], 1 + 5.0 / 6, 1e-15);
    for (int j = 0; j < 4; ++j)
      EXPECT_NEAR(w[j], weight_at(Weight::cubic_b_spline, std::abs(xi + 1 - j) / 2), 1e-15);
  }
}

// Splines of degree P on a grid of spacing h, with radius (P + 1) h / 2, sum to 1 everywhere.
template <class T>
void expect_partition_of_unity(double tolerance) {
  constexpr std::array<Weight, 5> splines{Weight::linear_b_spline, Weight::quadratic_b_spline,
                                          Weight::cubic_b_spline, Weight::quartic_b_spline,
                                          Weight::quintic_b_spline};
  for (int degree = 1; degree <= 5; ++degree)
    for (int i = 0; i < 1000; ++i) {
      const double x = i / 1000.0;
      std::array<T, 9> q, w;  // nodes -4 ... 4
      for (int k = 0; k < 9; ++k) q[k] = static_cast<T>(std::abs(x - (k - 4)) * 2 / (degree + 1));
      WeightFunction(splines[degree - 1]).evaluate(q.data(), w.data(), nullptr, q.size());
      double sum = 0;
      for (const T value : w) sum += static_cast<double>(value);
      ASSERT_NEAR(sum, 1, tolerance) << "degree " << degree << ", x " << x;
    }
}

TEST(Gong2015Weights, CardinalSplinesArePartitionsOfUnity) {
  expect_partition_of_unity<double>(4e-15);
  expect_partition_of_unity<float>(2e-6);
}

// Algorithms 1 and 2 of section 5.4, loop by loop, in 1-D on [0, cells * h]: sums at nodes.
struct Assembled {
  // 11, 12 and 22 of M; B with the data (as it must be) and without (as printed).
  std::vector<std::array<double, 3>> moments;
  std::vector<Eigen::Vector2d> with_data, without_data;

  Eigen::Matrix2d matrix(std::size_t i) const {
    return (Eigen::Matrix2d() << moments[i][0], moments[i][1], moments[i][1], moments[i][2])
        .finished();
  }
};

Assembled algorithm_1(const std::vector<double>& x_p, const std::vector<double>& v_p, int cells,
                      double h, double unit) {
  const auto nodes = static_cast<std::size_t>(cells) + 1;
  Assembled sum{std::vector<std::array<double, 3>>(nodes), {}, {}};
  sum.with_data.assign(nodes, Eigen::Vector2d::Zero());
  sum.without_data = sum.with_data;
  for (std::size_t p = 0; p < x_p.size(); ++p) {
    const int element = static_cast<int>(std::floor(x_p[p] / h));
    const auto w3 = cubic_pieces(x_p[p] / h - element);
    for (int j = 0; j < 4; ++j) {
      const int i = element - 1 + j;
      if (i < 0 || i > cells) continue;
      const double aijx = (i * h - x_p[p]) / unit;
      sum.moments[i][0] += w3[j];
      sum.moments[i][1] += w3[j] * aijx;
      sum.moments[i][2] += w3[j] * aijx * aijx;
      sum.without_data[i] += w3[j] * Eigen::Vector2d(1, aijx);
      sum.with_data[i] += w3[j] * Eigen::Vector2d(1, aijx) * v_p[p];
    }
  }
  return sum;
}

struct Bar {
  int cells;
  double h;
  std::vector<double> nodes, x_p, v_p;

  Bar(int number, double spacing, double jitter, std::uint64_t seed) : cells(number), h(spacing) {
    for (int i = 0; i <= cells; ++i) nodes.push_back(i * h);
    for (const auto& x :
         jittered_points<double, 1>(4 * static_cast<std::size_t>(cells), jitter, seed)) {
      x_p.push_back(x[0] * cells * h);
      v_p.push_back(std::cos(7 * x[0]));
    }
  }
  Eigen::VectorXd fitted(Solver solver) const {
    return reconstruct(points_of(x_p), points_of(nodes),
                       {.degree = 1, .neighbours = Radius{2 * h}, .solver = solver})
        .apply(field_of(v_p));
  }
};

// Right: B = sum w [1, d] v_p, M a = B, v_i = a_1. It is recon's fit.
TEST(Gong2015Algorithm1, WithDataInBEqualsRecon) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed)
    for (const double h : {0.1, 1e-5}) {
      const Bar bar(10, h, seed == 1 ? 0 : 0.5, seed);
      const Assembled sum = algorithm_1(bar.x_p, bar.v_p, bar.cells, h, h);
      for (const Solver solver :
           {Solver::moment_matrix, Solver::gram_schmidt, Solver::qr, Solver::svd}) {
        const Eigen::VectorXd v = bar.fitted(solver);
        for (int i = 0; i <= bar.cells; ++i) {
          const Eigen::Vector2d a = sum.matrix(i).ldlt().solve(sum.with_data[i]);
          EXPECT_NEAR(v[i], a[0], 1e-14) << name_of(solver) << ", h " << h << ", node " << i;
        }
      }
    }
}

// As printed, B has no data and algorithm 2 adds a_1 + d a_2 = 1 for every neighbour: their number.
TEST(Gong2015Algorithm2, AsPrintedCountsNeighbours) {
  const Bar bar(10, 0.1, 0.5, 3);
  const Assembled sum = algorithm_1(bar.x_p, bar.v_p, bar.cells, bar.h, bar.h);
  std::vector<double> v(bar.nodes.size(), 0);
  std::vector<int> neighbours(bar.nodes.size(), 0);
  for (const double x : bar.x_p)
    for (std::size_t i = 0; i < v.size(); ++i) {
      const double aijx = (bar.nodes[i] - x) / bar.h;
      if (std::abs(aijx) >= 2) continue;
      const Eigen::Vector2d a = sum.matrix(i).ldlt().solve(sum.without_data[i]);
      v[i] += a[0] + aijx * a[1];
      ++neighbours[i];
    }
  for (std::size_t i = 0; i < v.size(); ++i) {
    EXPECT_NEAR(v[i], neighbours[i], 1e-12);
    EXPECT_GE(neighbours[i], 5);
  }
}

// Lengths as they come make M ill conditioned on fine grids, 3e10 at h = 1e-5; d / h: 2.9.
TEST(Gong2015Algorithm1, NeedsScaledDistances) {
  const Bar bar(10, 1e-5, 0, 1);
  const auto condition = [&](double unit) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(
        algorithm_1(bar.x_p, bar.v_p, bar.cells, bar.h, unit).matrix(5));
    return eigen.eigenvalues()[1] / eigen.eigenvalues()[0];
  };
  EXPECT_NEAR(condition(1), 2.95e10, 0.1e10);
  EXPECT_NEAR(condition(bar.h), 2.95, 0.1);

  // recon always scales: the same fit as on the grid of spacing 0.1.
  const Bar large(10, 0.1, 0, 1);
  for (const Solver solver : {Solver::moment_matrix, Solver::gram_schmidt})
    EXPECT_LT((bar.fitted(solver) - large.fitted(solver)).cwiseAbs().maxCoeff(), 1e-14);
}

}  // namespace
}  // namespace recon
