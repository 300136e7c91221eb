// Grids of targets: what they refuse.
#include "recon/points/structured_grid.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "support/message_of.hpp"

namespace recon::testing {
namespace {

using ::testing::HasSubstr;

TEST(StructuredGrids, NameTheAxisOfWhatIsWrong) {
  const auto words = [](const StructuredGrid<double>& grid) {
    return message_of([&] { grid.validate(); });
  };
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_THAT(words({2, {0, 0}, {1, -1}, {3, 3}}), HasSubstr("grid spacing along y = -1: must be"));
  EXPECT_THAT(words({3, {0, 0, infinity}, {1, 1, 1}, {3, 3, 3}}),
              HasSubstr("grid origin along z = inf"));
  EXPECT_THAT(words({2, {0, 0}, {1, 1}, {0, 3}}), HasSubstr("grid nodes along x = 0"));
  EXPECT_THAT(words({1, {1e308}, {1e308}, {3}}), HasSubstr("last node of the grid along x = inf"));
}

// Nodes that round to one place are no grid: refused wherever two could coincide, and nowhere where
// the spacing is ten times the rounding.
template <class Scalar>
void check_spacings(const char* precision) {
  const Scalar eps = std::numeric_limits<Scalar>::epsilon();
  for (const Scalar origin : {Scalar(0), Scalar(1), Scalar(-3), Scalar(1e6)})
    for (const Scalar roundings : {Scalar(0.3), Scalar(0.6), Scalar(1), Scalar(1.4), Scalar(3)}) {
      StructuredGrid<Scalar> grid{2, {0, origin}, {1, roundings * eps * std::abs(origin)}, {3, 40}};
      if (origin == 0) grid.spacing[1] = eps * eps;
      const std::string words = message_of([&] { grid.validate(); });
      if (words == "no InvalidArgument was thrown") {
        for (std::size_t i = 1; i < 40; ++i)
          EXPECT_LT(grid.coordinate(i - 1, 1), grid.coordinate(i, 1)) << origin << ' ' << roundings;
      } else {
        EXPECT_LT(roundings, 3) << words;
        EXPECT_THAT(words, HasSubstr("grid spacing along y = "));
        EXPECT_THAT(words, HasSubstr("from the origin " + detail::to_text(origin) + " to "));
        EXPECT_THAT(words, HasSubstr(precision));
      }
    }
}

TEST(StructuredGrids, NeighbouringNodesHavePlacesOfTheirOwn) {
  check_spacings<float>("in float");
  check_spacings<double>("in double");
  // More nodes than a float can count: the last ones would coincide.
  const StructuredGrid<float> long_axis{1, {0}, {1}, {40'000'000}};
  EXPECT_THAT(message_of([&] { long_axis.validate(); }), HasSubstr("grid spacing along x = 1"));
  // One node has no neighbour.
  EXPECT_EQ(message_of([] {
              StructuredGrid<double>{1, {1e300}, {1e-300}, {1}}.validate();
            }),
            "no InvalidArgument was thrown");
}

}  // namespace
}  // namespace recon::testing
