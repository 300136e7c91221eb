// Limited values at nodes: the nearest in (or near) the range of the data in the node's support.
#include <gmock/gmock.h>

#include "grid_support.hpp"
#include "support/message_of.hpp"

namespace recon::testing {
namespace {

using ::testing::HasSubstr;

template <class C>
class GridLimits : public ::testing::Test {};
TYPED_TEST_SUITE(GridLimits, AllCases, CaseNames);

TYPED_TEST(GridLimits, ValuesAreTheNearestInTheRangeOfTheirData) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = random_points<Scalar, D>(D == 1 ? 30 : D == 2 ? 150 : 400, 3);
  StructuredGrid<Scalar> grid;
  grid.dimension = D;
  for (int d = 0; d < D; ++d) {
    grid.counts[d] = D == 1 ? 40 : D == 2 ? 14 : 8;
    grid.origin[d] = Scalar(-0.1);
    grid.spacing[d] = Scalar(1.2) / static_cast<Scalar>(grid.counts[d] - 1);
  }
  Matrix<Scalar> u(points.size(), 2);
  std::vector<double> mass;
  for (std::size_t p = 0; p < points.size(); ++p) {
    u(p, 0) = points[p][0] < Scalar(0.5) ? Scalar(0) : Scalar(1);
    u(p, 1) = std::sin(9 * points[p][D - 1]);
    mass.push_back(1 + static_cast<double>(points[p][0]));
  }
  for (const WeightForm form : {WeightForm::tensor_product, WeightForm::radial})
    for (int degree = 0; degree <= 2; ++degree) {
      Options options{.degree = degree, .form = form, .particle_weights = mass};
      const auto at = [&](Limit limit, int threads) {
        options.threads = threads;
        return reconstruct_on_grid(points_of(points), {field_of(u)}, grid, options,
                                   {.gradients = Derivative::diffuse, .limit = limit});
      };
      const auto plain = at(Limit::none, 1), strict = at(Limit::range, 1),
                 relaxed = at(Limit::relaxed, 3);
      EXPECT_TRUE(plain.limited().components.empty());
      std::size_t counted = 0;
      for (std::size_t i = 0; i < grid.size(); ++i) {
        if (plain.report()[i].status == FitStatus::no_support) continue;
        counted += strict.limited().components[i];
        for (int c = 0; c < 2; ++c) {
          Scalar least = std::numeric_limits<Scalar>::max(), greatest = -least, all_least = least,
                 all_greatest = greatest;
          for (std::size_t p = 0; p < points.size(); ++p) {
            all_least = std::min(all_least, u(p, c));
            all_greatest = std::max(all_greatest, u(p, c));
            double square = 0, farthest = 0;
            for (int d = 0; d < D; ++d) {
              const double xi = std::abs(
                  static_cast<double>(points[p][d] - grid.coordinate(grid.index(i)[d], d)) /
                  (2 * static_cast<double>(grid.spacing[d])));
              square += xi * xi;
              farthest = std::max(farthest, xi);
            }
            if ((form == WeightForm::radial ? square : farthest) >= 1) continue;
            least = std::min(least, u(p, c));
            greatest = std::max(greatest, u(p, c));
          }
          EXPECT_EQ(strict.values()(i, c), std::clamp(plain.values()(i, c), least, greatest));
          const Scalar more = greatest - least;
          EXPECT_NEAR(relaxed.values()(i, c),
                      std::clamp(plain.values()(i, c), std::max(all_least, least - more),
                                 std::min(all_greatest, greatest + more)),
                      4 * TypeParam::eps);
        }
      }
      EXPECT_EQ(strict.limited().values, counted);
      if (degree == 2) {
        EXPECT_GT(counted, 3u);
      }
      if (degree == 0) {
        EXPECT_EQ(counted, 0u);
      }
      EXPECT_LE(relaxed.limited().values, strict.limited().values);
      EXPECT_EQ(strict.gradients().size(), plain.gradients().size());
      for (Eigen::Index i = 0; i < plain.gradients().size(); ++i) {
        const Scalar g = plain.gradients().data()[i], h = strict.gradients().data()[i];
        EXPECT_TRUE(g == h || (std::isnan(g) && std::isnan(h))) << "gradients are never limited";
      }
    }
}

TEST(GridLimit, MomentsRefuseIt) {
  const PointList<double, 1> points{{0.1}, {0.5}};
  StructuredGrid<double> grid;
  grid.dimension = 1;
  grid.counts[0] = 3;
  const std::vector<double> u{1, 2};
  EXPECT_THAT(message_of([&] {
                GridMoments(points_of(points), {field_of(u)}, grid).solve({.limit = Limit::range});
              }),
              HasSubstr("the range of the data is not among them"));
}

}  // namespace
}  // namespace recon::testing
