// Fields as they lie in other people's memory, and what is said of data that are not finite.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "recon/operators/kernel_sum.hpp"
#include "recon/operators/reconstruct.hpp"
#include "recon/points/generate.hpp"
#include "recon/points/structured_grid.hpp"
#include "support/message_of.hpp"

namespace recon::testing {
namespace {

using Eigen::MatrixXd;
using ::testing::HasSubstr;

struct Grain {
  std::array<double, 3> position, velocity;
  float mass;  // a stride that is a multiple of 8 only by padding
  char flag;
};

class Fields : public ::testing::Test {
 protected:
  static constexpr std::size_t count = 700;
  Fields() {
    RandomNumbers random(4);
    for (const auto& x : random_points<double, 3>(count, 1)) {
      Grain grain{x, {}, 1, 'a'};
      for (double& v : grain.velocity) v = random.uniform(-1, 1);
      grains.push_back(grain);
      vx.push_back(grain.velocity[0]);
      vy.push_back(grain.velocity[1]);
      vz.push_back(grain.velocity[2]);
    }
    matrix.resize(count, 3);
    for (std::size_t p = 0; p < count; ++p)
      for (int c = 0; c < 3; ++c) matrix(p, c) = grains[p].velocity[c];
  }
  Reconstruction fit(const Options& options = {}) const {
    const auto points = points_of(grains, &Grain::position);
    return reconstruct(points, points, options);
  }

  std::vector<Grain> grains;
  std::vector<double> vx, vy, vz;
  MatrixXd matrix;  // a column for each component
};

TEST_F(Fields, OfAnyLayoutGiveTheSameBits) {
  const Reconstruction f = fit();
  const auto velocity = field_of(grains, &Grain::velocity);
  const MatrixXd v = f.apply(velocity), g = f.gradient().apply(velocity);
  EXPECT_EQ(f.apply(field_of(vx, vy, vz)), v);
  EXPECT_EQ(f.apply(field_of(matrix)), v);
  EXPECT_EQ(f.gradient().apply(field_of(vx, vy, vz)), g);
  EXPECT_EQ(f.gradient().apply(field_of(matrix)), g);
  EXPECT_EQ(f.apply_transpose(field_of(vx, vy, vz)), f.apply_transpose(velocity));

  std::vector<double> a(count), b(count), c(count);
  f.apply(velocity, field_of(a, b, c));
  for (std::size_t t = 0; t < count; ++t) {
    EXPECT_EQ(a[t], v(t, 0));
    EXPECT_EQ(b[t], v(t, 1));
    EXPECT_EQ(c[t], v(t, 2));
  }
  f.apply(field_of(vx, vy, vz), field_of(a, b, c), trusted);
  EXPECT_EQ(c[5], v(5, 2));
}

TEST_F(Fields, LengthsOfArraysMustAgree) {
  vy.pop_back();
  EXPECT_THAT(message_of([&] { field_of(vx, vy, vz); }),
              HasSubstr("length of array 1 = 699: must be that of array 0, 700"));
}

TEST_F(Fields, NumbersThatAreNotFiniteAreNamed) {
  const Reconstruction f = fit();
  for (const double bad : {double(NAN), HUGE_VAL, -HUGE_VAL}) {
    auto spoilt = vy;
    spoilt[31] = bad;
    const std::string what = "component 1 of the field at point 31";
    EXPECT_THAT(message_of([&] { f.apply(field_of(vx, spoilt, vz)); }), HasSubstr(what));
    EXPECT_THAT(message_of([&] { f.gradient().apply(field_of(vx, spoilt, vz)); }), HasSubstr(what));
    EXPECT_THAT(message_of([&] { f.apply_transpose(field_of(vx, spoilt, vz)); }), HasSubstr(what));
    EXPECT_THAT(message_of([&] { f.apply(field_of(vx, spoilt, vz), {.limit = Limit::range}); }),
                HasSubstr(what));
    // Trusted data are passed on: targets that the particle reaches, and no others, are spoilt.
    std::vector<double> a(count), b(count), c(count);
    f.apply(field_of(vx, spoilt, vz), field_of(a, b, c), trusted);
    EXPECT_FALSE(std::isfinite(b[31]));
    std::size_t lost = 0;
    for (std::size_t t = 0; t < count; ++t) {
      EXPECT_TRUE(std::isfinite(a[t]) && std::isfinite(c[t]));
      lost += !std::isfinite(b[t]);
    }
    EXPECT_GT(lost, 1u);
    EXPECT_LT(lost, 100u);
  }
}

// Those that no target needs are not looked at.
TEST_F(Fields, NumbersThatNoTargetNeedsDoNotMatter) {
  const std::vector<std::array<double, 3>> corner{{0.05, 0.05, 0.05}};
  const auto points = points_of(grains, &Grain::position);
  const Reconstruction f = reconstruct(points, points_of(corner), {.neighbours = Radius{0.4}});
  const NeighbourList<double> list = f.neighbours();
  for (std::size_t p = 0; p < count; ++p)
    if (std::find(list.indices.begin(), list.indices.end(), p) == list.indices.end()) vx[p] = NAN;
  EXPECT_TRUE(std::isfinite(f.apply(field_of(vx))(0, 0)));
}

// The sums that numbers of the SPH literature are: the density of a lattice, mass that is kept, a constant
// weight by hand.
TEST(KernelSums, AreTheirFormula) {
  const auto points = random_points<double, 2>(400, 1);
  const auto targets = random_points<double, 2>(50, 2);
  const Sources sources(points_of(points));
  std::vector<double> mass;
  for (std::size_t p = 0; p < points.size(); ++p) mass.push_back(1 + 0.01 * static_cast<double>(p));
  const double rho = 0.17;
  for (const WeightForm form : {WeightForm::radial, WeightForm::tensor_product}) {
    const MatrixXd sums =
        kernel_operator(sources, points_of(targets),
                        {.weight = Weight::wendland_c2, .form = form, .support = Radius{rho}})
            .apply(field_of(mass));
    // c of (1 - q)^4 (4 q + 1): pi / 7 over the disk; the square of 2 / 3 as a product.
    const double c = form == WeightForm::radial ? std::acos(-1.0) / 7 : 4.0 / 9;
    const auto w = [](double q) { return q < 1 ? std::pow(1 - q, 4) * (4 * q + 1) : 0; };
    for (std::size_t t = 0; t < targets.size(); ++t) {
      double sum = 0;
      for (std::size_t p = 0; p < points.size(); ++p) {
        const double x = std::abs(points[p][0] - targets[t][0]) / rho,
                     y = std::abs(points[p][1] - targets[t][1]) / rho;
        sum += mass[p] * (form == WeightForm::radial ? w(std::hypot(x, y)) : w(x) * w(y));
      }
      EXPECT_NEAR(sums(t, 0), sum / (c * rho * rho), 1e-9 * sum / (c * rho * rho));
    }
  }
  EXPECT_EQ(
      kernel_sum(sources, points_of(targets), field_of(mass), Weight::cubic_b_spline, rho),
      kernel_operator(sources, points_of(targets), {.support = Radius{rho}}).apply(field_of(mass)));
}

TEST(KernelSums, KeepTheMassOfAPeriodicBox) {
  const auto points = random_points<double, 3>(300, 1);
  const PeriodicDomain<double> box{{0, 0, 0}, {1, 1, 1}, {true, true, true}};
  const Sources sources(points_of(points), {.domain = box});
  const StructuredGrid<double> grid{3, {0.025, 0.025, 0.025}, {0.05, 0.05, 0.05}, {20, 20, 20}};
  const auto nodes = grid.nodes();
  const std::vector<std::array<double, 2>> amounts(points.size(), {2, -1});
  const auto op = kernel_operator(sources, nodes.view(), {.support = Radius{0.4}});
  const MatrixXd sums = op.apply(field_of(amounts));
  EXPECT_NEAR(sums.col(0).sum() * std::pow(0.05, 3), 600, 1);
  EXPECT_NEAR(sums.col(1).sum() * std::pow(0.05, 3), -300, 0.5);
  // What the targets have is what the particles give: the transpose.
  const std::vector<double> ones(nodes.view().size(), 1.0);
  EXPECT_NEAR(op.apply_transpose(field_of(ones)).sum() * 2, sums.col(0).sum(), 1e-8);
}

TEST(KernelSums, TakeAllParticlesInTheSupportOfTheKNearest) {
  const auto points = random_points<double, 2>(400, 1);
  const Sources sources(points_of(points));
  const auto op = kernel_operator(sources, points_of(points), {.support = Nearest{5, 2.0}});
  const auto list = find_neighbours(sources, points_of(points), Nearest{5, 2.0});
  for (std::size_t t = 0; t < points.size(); ++t) {
    std::size_t inside = 0;
    for (const auto& p : points)
      inside += std::hypot(p[0] - points[t][0], p[1] - points[t][1]) <= list.support[t];
    EXPECT_EQ(op.row(t).size(), inside);
  }
}

// W scales with rho^-D down to where it is no normal number any more; there is an error with the
// radius, and never a W without its digits.
template <class Scalar>
void check_scales(int dimension, const std::vector<double>& good, const std::vector<double>& bad) {
  const std::vector<std::array<Scalar, 3>> unit{
      {0, 0, 0}, {Scalar(0.5), 0, 0}, {0, Scalar(0.25), 0}};
  const std::vector<Scalar> mass{3, 1, 2};
  const auto sums = [&](double radius) {
    std::vector<Scalar> x[3];
    for (const auto& at : unit)
      for (int d = 0; d < 3; ++d) x[d].push_back(static_cast<Scalar>(at[d] * radius));
    const PointsView<Scalar> points = dimension == 1   ? points_of(x[0])
                                      : dimension == 2 ? points_of(x[0], x[1])
                                                       : points_of(x[0], x[1], x[2]);
    const BasicSources<Scalar> sources(points);
    const std::vector<double> radii{radius, 2 * radius, radius};
    return kernel_operator<Scalar>(sources, points, {.support = Radii{radii}})
        .apply(field_of(mass))
        .template cast<double>()
        .eval();
  };
  const MatrixXd reference = sums(1);
  const double eps = std::numeric_limits<Scalar>::epsilon();
  for (const double radius : good) {
    const MatrixXd scaled = sums(radius);
    for (int t = 0; t < 3; ++t)
      EXPECT_NEAR(scaled(t, 0) * std::pow(radius, dimension) / reference(t, 0), 1, 40 * eps)
          << radius << " in " << dimension << "-D";
  }
  const std::string precision = sizeof(Scalar) == 4 ? "in float" : "in double";
  for (const double radius : bad)
    EXPECT_THAT(message_of([&] { sums(radius); }),
                ::testing::AllOf(HasSubstr("support radius of target 0 in a kernel sum = " +
                                           detail::to_text(static_cast<Scalar>(radius)) +
                                           ": must have a 1 / (c "),
                                 HasSubstr("normal number " + precision)));
}

TEST(KernelSums, KeepTheirDigitsOrNameTheRadius) {
  check_scales<float>(3, {1e-12, 1e-9, 1e12}, {1e-13, 1e-16, 1e13, 1e16});
  check_scales<float>(2, {1e-18, 1e18}, {});
  check_scales<float>(1, {1e-18, 1e18}, {});
  check_scales<double>(3, {1e-102, 1e-60, 1e102}, {1e-103, 1e-120, 1e103, 1e120});
  check_scales<double>(2, {1e-150, 1e150}, {});
}

// Narrow weights have all of their integral near 0; closed forms of those that have one.
TEST(KernelSums, IntegralsOfNarrowWeights) {
  const double pi = std::acos(-1.0);
  for (const double c : {0.3, 1e-2, 1e-4, 1e-6}) {
    if (c < 0.1) {  // exp(-1 / c^2) is nothing
      EXPECT_NEAR(weight_integral(Gaussian{c}, WeightForm::radial, 1) / (std::sqrt(pi) * c), 1,
                  1e-8);
      EXPECT_NEAR(
          weight_integral(Gaussian{c}, WeightForm::radial, 3) / std::pow(std::sqrt(pi) * c, 3), 1,
          1e-8);
    }
    // The integral of (1 - q)^2 / (q^2 + c^2) over -1 to 1.
    const double exact = 2 * ((1 - c * c) * std::atan(1 / c) / c - std::log1p(1 / (c * c)) + 1);
    EXPECT_NEAR(weight_integral(InverseDistance{c}, WeightForm::radial, 1) / exact, 1, 1e-8) << c;
  }
  EXPECT_THAT(message_of([] { weight_integral(Gaussian{}, WeightForm::radial, 4); }),
              HasSubstr("dimension = 4"));
}

TEST(KernelSums, OfNoParticleAreZeroAndMistakesAreNamed) {
  const std::vector<std::array<double, 2>> points{{0, 0}, {1, 0}}, far{{9, 9}};
  const std::vector<double> mass{1, 2};
  Sources sources(points_of(points));
  const auto op = kernel_operator(sources, points_of(far), {.support = Radius{0.5}});
  EXPECT_EQ(op.apply(field_of(mass))(0, 0), 0);
  EXPECT_THAT(message_of([&] {
                kernel_sum(sources, points_of(far), field_of(mass), Weight::gaussian, -1);
              }),
              HasSubstr("radius = -1"));
  sources.update(points_of(points));
  EXPECT_THAT(message_of([&] { op.apply(field_of(mass)); }), HasSubstr("update"));
}

}  // namespace
}  // namespace recon::testing
