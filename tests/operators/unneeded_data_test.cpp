// Data that are multiplied by 0 are not needed: NaN there changes no bit of a checked product, and
// passes in a trusted one. Data that are needed are named, with the caller's numbers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "recon/points/generate.hpp"
#include "recon/recon.hpp"
#include "support/message_of.hpp"
#include "support/typed.hpp"

namespace recon::testing {
namespace {

using ::testing::HasSubstr;

// The points with whole coordinates from -3 to 3.
template <class Scalar, int D>
std::vector<std::array<Scalar, D>> lattice() {
  std::vector<std::array<Scalar, D>> points;
  for (int n = 0; n < std::pow(7, D); ++n) {
    std::array<Scalar, D> x;
    for (int d = 0, rest = n; d < D; ++d, rest /= 7) x[d] = static_cast<Scalar>(rest % 7 - 3);
    points.push_back(x);
  }
  return points;
}

template <class Scalar, std::size_t D>
double distance(const std::array<Scalar, D>& x) {
  double sum = 0;
  for (const Scalar along : x) sum += static_cast<double>(along) * static_cast<double>(along);
  return std::sqrt(sum);
}

template <class C>
class UnneededData : public ::testing::Test {};
TYPED_TEST_SUITE(UnneededData, AllCases, CaseNames);

// A target at 0 with a radius of 2 or 3 has particles exactly on the border of its support; in 3-D
// with 3 it has more than 32 neighbours, whose sums are formed in parts.
TYPED_TEST(UnneededData, OnTheBorderOfASupportMayBeAnything) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = lattice<Scalar, D>();
  const std::vector<std::array<Scalar, D>> targets(1);
  for (const double radius : {2.0, 3.0}) {
    const BasicReconstruction<Scalar> fit(points_of(points), points_of(targets),
                                          {.degree = 1, .neighbours = Radius{radius}});
    const auto slopes = fit.gradient();
    ASSERT_EQ(fit.values().row(0).size(),
              static_cast<std::size_t>(std::count_if(
                  points.begin(), points.end(), [&](auto& x) { return distance(x) <= radius; })));
    for (const int components : {1, 2, 3, 4, 6}) {
      std::vector<Scalar> u, with_nan, with_zero;
      std::vector<std::vector<Scalar>> arrays(static_cast<std::size_t>(components));
      for (std::size_t p = 0; p < points.size(); ++p)
        for (int c = 0; c < components; ++c) {
          const auto value = static_cast<Scalar>(std::sin(3.0 * static_cast<double>(p) + c));
          const bool border = distance(points[p]) == radius;
          u.push_back(value);
          with_zero.push_back(border ? Scalar(0) : value);
          with_nan.push_back(border ? std::numeric_limits<Scalar>::quiet_NaN() : value);
          arrays[static_cast<std::size_t>(c)].push_back(with_nan.back());
        }
      const auto view = [&](const std::vector<Scalar>& values) {
        return FieldView<Scalar>(points.size(), components, values.data(),
                                 components * static_cast<std::ptrdiff_t>(sizeof(Scalar)),
                                 sizeof(Scalar));
      };
      std::vector<const void*> first;
      for (const auto& array : arrays) first.push_back(array.data());
      const FieldView<Scalar> separate(points.size(), components, first, sizeof(Scalar));
      for (const Limit limit : {Limit::none, Limit::range}) {
        const auto expected = fit.apply(view(u), {.limit = limit});
        EXPECT_TRUE(expected.allFinite());
        EXPECT_EQ(fit.apply(view(with_zero), {.limit = limit}), expected);
        EXPECT_EQ(fit.apply(view(with_nan), {.limit = limit}), expected) << components;
        EXPECT_EQ(fit.apply(separate, {.limit = limit}), expected) << components;
      }
      EXPECT_EQ(slopes.apply(view(with_nan)), slopes.apply(view(u))) << components;
      // Trusted data are not looked at.
      typename CsrOperator<Scalar>::Matrix out(1, components);
      fit.apply(view(with_nan), field_of(out), trusted);
      EXPECT_TRUE(out.array().isNaN().all());
      // Where a coefficient is not 0, a number is needed.
      for (std::size_t p = 0; p < points.size(); ++p) {
        if (distance(points[p]) >= radius || fit.values().row(0).size() == 0) continue;
        auto bad = with_nan;
        bad[(p + 1) * static_cast<std::size_t>(components) - 1] =
            std::numeric_limits<Scalar>::infinity();
        EXPECT_THAT(message_of([&] { fit.apply(view(bad)); }),
                    HasSubstr("component " + std::to_string(components - 1) +
                              " of the field at point " + std::to_string(p) + " = inf"));
        break;
      }
    }
  }
}

// Of targets: second derivatives of degree 1 are zero everywhere, and across a line the slope is.
TEST(UnneededTargets, OfZeroRowsMayBeAnything) {
  const double nan = std::nan("");
  std::vector<std::array<double, 2>> line;
  for (int i = 0; i < 9; ++i) line.push_back({0.1 * i, 0});
  const std::vector<std::array<double, 2>> targets{{0.32, 0}, {0.51, 0}};
  const Reconstruction fit =
      reconstruct(points_of(line), points_of(targets), {.degree = 1, .neighbours = Radius{0.3}});
  const std::vector<std::array<double, 3>> second{{nan, 1, nan}, {nan, nan, nan}};
  EXPECT_TRUE(fit.hessian().apply_transpose(field_of(second)).isZero(0));

  const CsrOperator<double> slopes = fit.gradient();
  std::vector<std::array<double, 2>> f{{1, 5}, {-2, 5}}, across = f;
  across[0][1] = across[1][1] = nan;
  EXPECT_EQ(slopes.apply_transpose(field_of(across)), slopes.apply_transpose(field_of(f)));
  f[1][0] = nan;
  EXPECT_THAT(message_of([&] { slopes.apply_transpose(field_of(f)); }),
              HasSubstr("component 0 of the field at point 1 = nan"));
  // du_x/dx is all that the divergence has here; the curl has du_y/dx.
  const auto made = fit.operators(Functional::divergence, Functional::curl);
  const VectorOperator<double>&divergence = std::get<0>(made), &curl = std::get<1>(made);
  const std::vector<double> g{1, nan};
  EXPECT_THAT(message_of([&] { divergence.apply_transpose(field_of(g)); }),
              HasSubstr("component 0 of the field at point 1 = nan"));
  EXPECT_THAT(message_of([&] { curl.apply_transpose(field_of(g)); }),
              HasSubstr("component 0 of the field at point 1 = nan"));
}

// Messages of what mixes components speak of the components that the caller has given or gets.
TEST(VectorOperators, NameTheCallersComponents) {
  const auto points = random_points<double, 3>(300, 1), targets = random_points<double, 3>(9, 2);
  const Reconstruction fit = reconstruct(points_of(points), points_of(targets), {.degree = 1});
  const auto made =
      fit.operators(Functional::curl, Functional::strain_rate, Functional::divergence);
  const VectorOperator<double>&curl = std::get<0>(made), &strain = std::get<1>(made),
        &divergence = std::get<2>(made);
  std::vector<std::array<double, 3>> f(targets.size(), {1, 2, 3});
  f[4][2] = std::nan("");
  EXPECT_THAT(message_of([&] { curl.apply_transpose(field_of(f)); }),
              HasSubstr("component 2 of the field at point 4 = nan: must be finite"));
  std::vector<std::array<double, 6>> s(targets.size());
  s[7][5] = HUGE_VAL;
  EXPECT_THAT(message_of([&] { strain.apply_transpose(field_of(s)); }),
              HasSubstr("component 5 of the field at point 7 = inf: must be finite"));
  std::vector<std::array<double, 3>> u(points.size(), std::array<double, 3>{1, 2, 3});
  const ParticleIndex needed = fit.values().row(3).particle(0);
  u[needed][1] = std::nan("");
  for (const auto* op : {&curl, &strain, &divergence})
    EXPECT_THAT(
        message_of([&] { op->apply(field_of(u)); }),
        HasSubstr("component 1 of the field at point " + std::to_string(needed) + " = nan"));
  // A slope that overflows is charged to the number that needs it, and to no other.
  const double top = std::numeric_limits<double>::max();
  for (std::size_t p = 0; p < points.size(); ++p) u[p] = {0, (2 * points[p][1] - 1) * top, 0};
  EXPECT_THAT(message_of([&] { strain.apply(field_of(u)); }),
              HasSubstr("component 3 of the result at target 0"));
  for (std::size_t p = 0; p < points.size(); ++p) u[p] = {(2 * points[p][0] - 1) * top, 0, 0};
  const auto turning = curl.apply(field_of(u));
  EXPECT_TRUE(turning.allFinite());
  EXPECT_EQ(turning.col(0).cwiseAbs().maxCoeff(), 0);  // du_z/dy - du_y/dz
}

// NaN of particles that are no target's business, and on the border for a vector operator.
TEST(VectorOperators, IgnoreWhatIsMultipliedByZero) {
  const auto points = lattice<double, 2>();
  const std::vector<std::array<double, 2>> targets(1);
  const Reconstruction fit =
      reconstruct(points_of(points), points_of(targets), {.degree = 1, .neighbours = Radius{2}});
  const auto [divergence] = fit.operators(Functional::divergence);
  std::vector<std::array<double, 2>> u;
  for (const auto& x : points)
    u.push_back(distance(x) < 2 ? std::array{2 * x[0] - x[1], 3 * x[1]}
                                : std::array{std::nan(""), HUGE_VAL});
  EXPECT_NEAR(divergence.apply(field_of(u))(0, 0), 5, 1e-13);
}

// Entries that leave the range of numbers are refused, and the operator stays what it was.
TEST(OperatorArithmetic, RefusesEntriesThatOverflow) {
  const auto points = random_points<double, 2>(200, 1), targets = random_points<double, 2>(20, 2);
  const Reconstruction fit = reconstruct(points_of(points), points_of(targets), {.degree = 1});
  std::vector<double> u;
  for (const auto& x : points) u.push_back(x[0] - 2 * x[1]);
  CsrOperator<double> slopes = fit.gradient();
  const auto before = slopes.apply(field_of(u));
  EXPECT_THAT(message_of([&] { slopes *= 1e308; }),
              ::testing::ContainsRegex("coefficient of particle [0-9]+ at target [0-9]+ in block "
                                       "[01] = -?inf: overflows"));
  EXPECT_THAT(message_of([&] { slopes *= std::nan(""); }), HasSubstr("factor of the operator"));
  EXPECT_EQ(slopes.apply(field_of(u)), before);

  // The largest entry becomes the largest number; its double does not exist.
  double largest = 0;
  std::size_t target = 0;
  ParticleIndex particle = 0;
  for (std::size_t t = 0; t < targets.size(); ++t) {
    const auto row = slopes.row(t);
    for (std::size_t i = 0; i < row.size(); ++i)
      for (int b = 0; b < 2; ++b)
        if (std::abs(row.value(i, b)) > largest) {
          largest = std::abs(row.value(i, b));
          target = t;
          particle = row.particle(i);
        }
  }
  CsrOperator<double> high = slopes * (std::numeric_limits<double>::max() / largest * 0.51);
  const std::string where = "coefficient of particle " + std::to_string(particle) + " at target " +
                            std::to_string(target) + " in block ";
  const CsrOperator<double> same = high;
  for (const std::string& words :
       {message_of([&] { high += same; }), message_of([&] { (-1.0) * high - same; }),
        message_of([&] { 2.0 * high; })})
    EXPECT_THAT(words, HasSubstr("overflows"));
  // Only the largest is above half of the largest number where the next is at most 0.98 of it.
  EXPECT_EQ((high - same).apply(field_of(u)).cwiseAbs().maxCoeff(), 0);
  EXPECT_THAT(message_of([&] { high += same; }), HasSubstr(where));
}

}  // namespace
}  // namespace recon::testing
