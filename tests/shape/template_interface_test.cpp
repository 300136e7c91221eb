// The template interface with a minimal model of every concept: own weight, own basis, own
// search, own scalar.
#include <gtest/gtest.h>

#include "recon/neighbourhood/kd_tree.hpp"
#include "recon/points/generate.hpp"
#include "recon/recon.hpp"
#include "recon/shape/shape_function.hpp"
#include "support/invariants.hpp"

namespace recon {
namespace {

// RadialWeight: two functions of q.
struct Parabola {
  template <class T>
  T operator()(T q) const {
    return (1 - q) * (1 - q);
  }
  template <class T>
  T derivative(T q) const {
    return -2 * (1 - q);
  }
};
static_assert(RadialWeight<Parabola>);

// Basis: 1 | x, y | sin(2 x): reproduces a wave along x exactly.
struct Wave {
  static constexpr int dimension = 2, degree = 2, size = 4;
  static constexpr int begin(int k) { return k == 0 ? 0 : k == 1 ? 1 : k == 2 ? 3 : 4; }
  template <class T>
  static void evaluate(const std::array<T, 2>& xi, T* values) {
    values[0] = 1;
    values[1] = xi[0];
    values[2] = xi[1];
    values[3] = std::sin(2 * xi[0]);
  }
  // Taylor coefficients at 0: sin(2 x) = 2 x + ...
  static constexpr double origin(int term, int coefficient) {
    if (term == 3) return coefficient == 1 ? 2 : 0;
    return term == coefficient ? 1 : 0;
  }
};
static_assert(Basis<Wave>);

// NeighbourSearch: everything, always; shape functions outside the support are zero anyway.
struct All {
  static constexpr int dimension = 2;
  using Scalar = double;
  std::size_t count;
  std::size_t size() const { return count; }
  void within(const std::array<double, 2>&, double, std::vector<Neighbour<double>>& found) const {
    found.clear();
    for (ParticleIndex p = 0; p < count; ++p) found.push_back({p, 0});
  }
  void nearest(const std::array<double, 2>& x, std::size_t,
               std::vector<Neighbour<double>>& found) const {
    within(x, 0, found);
  }
  void nearest_within(const std::array<double, 2>& x, std::size_t, double,
                      std::vector<Neighbour<double>>& found) const {
    within(x, 0, found);
  }
  void in_box(const std::array<double, 2>& lower, const std::array<double, 2>&,
              std::vector<Neighbour<double>>& found) const {
    within(lower, 0, found);
  }
};
static_assert(NeighbourSearch<All>);
static_assert(NeighbourSearch<KdTree<double, 2>> && NeighbourSearch<KdTree<float, 3>>);

TEST(TemplateInterface, OwnWeightBasisAndSearch) {
  const auto points = random_points<double, 2>(200, 1);
  const auto position = [&](ParticleIndex p) { return points[p]; };
  ShapeEvaluator<Wave, Parabola> shapes(Parabola{});
  const double rho = 0.4;
  for (const auto& x : random_points<double, 2>(30, 2)) {
    const auto& shape = shapes.at(x, rho, All{points.size()}, position);
    ASSERT_EQ(shape.report.status, FitStatus::full);
    // u = 1 + 2 y + sin(2 (x_p - x) / rho): the wave of the basis; u(x) = 1 + 2 y, du/dx = 2 /
    // rho, du/dy = 2.
    double value = 0, slope_x = 0, slope_y = 0;
    for (std::size_t i = 0; i < shape.neighbours.size(); ++i) {
      const auto& p = points[shape.neighbours[i]];
      const double u = 1 + 2 * p[1] + std::sin(2 * (p[0] - x[0]) / rho);
      value += shape.value[i] * u;
      slope_x += shape.gradient[i][0] * u;
      slope_y += shape.gradient[i][1] * u;
    }
    EXPECT_NEAR(value, 1 + 2 * x[1], 1e-12);
    EXPECT_NEAR(slope_y, 2, 1e-10);
    EXPECT_NEAR(slope_x, 2 / rho, 1e-10);
    // A wave that moves with the target is another space at every target: no exact gradient.
    EXPECT_THROW(shapes.at(x, rho, All{points.size()}, position, Derivative::exact),
                 InvalidArgument);
  }
}

TEST(TemplateInterface, EqualsTheRunTimeInterface) {
  const auto points = random_points<double, 2>(300, 1), targets = random_points<double, 2>(40, 2);
  const PointCloud<double> cloud(points_of(points));
  const KdTree<double, 2> search(cloud);
  for (const Solver solver : {Solver::moment_matrix, Solver::gram_schmidt}) {
    // In the order of the search.
    const auto list = find_neighbours(cloud, PointCloud<double>(points_of(targets)), Radius{0.2});
    const auto fit = reconstruct(points_of(points), points_of(targets), list,
                                 {.degree = 2, .weight = Parabola{}, .solver = solver});
    const auto gradient = fit.gradient();
    ShapeEvaluator<Monomials<2, 2>, Parabola> shapes(Parabola{}, solver);
    for (std::size_t t = 0; t < targets.size(); ++t) {
      const auto& shape =
          shapes.at(targets[t], 0.2, search, [&](ParticleIndex p) { return points[p]; });
      EXPECT_EQ(shape.report, fit.report()[t]);
      double largest_slope = 1;
      for (const auto& slopes : shape.gradient)
        for (const double slope : slopes) largest_slope = std::max(largest_slope, std::abs(slope));
      for (std::size_t i = 0; i < shape.neighbours.size(); ++i) {
        EXPECT_EQ(shape.neighbours[i], fit.values().row(t).particle(i));
        const double tolerance = testing::rounding<double>(shape.report);
        EXPECT_NEAR(shape.value[i], fit.values().row(t).value(i), tolerance);
        for (int d = 0; d < 2; ++d)
          EXPECT_NEAR(shape.gradient[i][d], gradient.row(t).value(i, d), tolerance * largest_slope);
      }
    }
  }
}

TEST(TemplateInterface, DegreeBeyondTheCompiledOnes) {
  const auto points = random_points<double, 2>(400, 1);
  const PointCloud<double> cloud(points_of(points));
  const KdTree<double, 2> search(cloud);
  ShapeEvaluator<Monomials<2, 6>, BSpline<5>> shapes(BSpline<5>{});
  const std::array<double, 2> x{0.45, 0.55};
  const auto& shape = shapes.at(x, 0.45, search, [&](ParticleIndex p) { return points[p]; });
  EXPECT_EQ(shape.report.degree, 6);
  double value = 0;
  for (std::size_t i = 0; i < shape.neighbours.size(); ++i) {
    const auto& p = points[shape.neighbours[i]];
    value += shape.value[i] * std::pow(p[0], 3) * std::pow(p[1], 3);
  }
  EXPECT_NEAR(value, std::pow(0.45, 3) * std::pow(0.55, 3), 1e-13);
}

TEST(TemplateInterface, BadSupportIsNamed) {
  ShapeEvaluator<Monomials<1, 1>, BSpline<3>> shapes(BSpline<3>{});
  const std::vector<ParticleIndex> none;
  const auto position = [](ParticleIndex) { return std::array<double, 1>{0}; };
  EXPECT_THROW(shapes.at({0}, -1, std::span(none), position), InvalidArgument);
  EXPECT_THROW(shapes.at({std::nan("")}, 1, std::span(none), position), InvalidArgument);
  EXPECT_EQ(shapes.at({0}, 1, std::span(none), position).report.status, FitStatus::no_support);
}

// A million particles in one support, in float: the shape functions still sum to one.
TEST(TemplateInterface, ManyParticlesInFloat) {
  const std::size_t count = 1'000'000;
  const auto points = random_points<float, 2>(count, 3);
  std::vector<ParticleIndex> all(count);
  for (std::size_t p = 0; p < count; ++p) all[p] = static_cast<ParticleIndex>(p);
  for (const Solver solver : {Solver::moment_matrix, Solver::gram_schmidt}) {
    ShapeEvaluator<Monomials<2, 1>, Wendland<2>, float> shapes(Wendland<2>{}, solver);
    const auto& shape = shapes.at({0.4f, 0.5f}, 1.5f, std::span<const ParticleIndex>(all),
                                  [&](ParticleIndex p) { return points[p]; });
    double one = 0, x = 0, slope = 0;
    for (std::size_t p = 0; p < count; ++p) {
      one += static_cast<double>(shape.value[p]);
      x += static_cast<double>(shape.value[p] * points[p][0]);
      slope += static_cast<double>(shape.gradient[p][0] * points[p][0]);
    }
    EXPECT_NEAR(one, 1, 3e-6);
    EXPECT_NEAR(x, 0.4, 3e-6);
    EXPECT_NEAR(slope, 1, 3e-5);
  }
}

}  // namespace
}  // namespace recon
