// Sums between a particle and rows of nodes: what it gives is the transpose of what it takes, and
// this is what NodeFunctions say, with every instruction set.
#include <cmath>

#include "recon/transfer/modes.hpp"
#include "support/space.hpp"
#include "transfer/node_rows.hpp"

namespace recon::test {
namespace {

constexpr double rounding_of_rows = 1e-12;  // of sums of up to 64 products of numbers of about 1

template <class T>
class RowKernel : public ::testing::Test {};
TYPED_TEST_SUITE(RowKernel, AllDimensions);

// Calls work(kernels, functions at a point, random), with every set and in many places.
template <int D, class Work>
void with_places(const Work& work) {
  const CartesianGrid<D> grid = unit_grid<D>(5);
  for (const InstructionSet set : available_instruction_sets()) {
    SCOPED_TRACE(name_of(set));
    const detail::RowKernels<D> kernels(set);
    std::mt19937 random(3);
    for (int round = 0; round < 20; ++round) {
      const SpaceVector<D> x = random_point<D>(random);
      const auto with = [&](const auto& functions) {
        typename std::decay_t<decltype(functions)>::template Nodes<D> at;
        functions.at(grid, x, at);
        PolynomialModes<D> modes;
        modes.fill(grid, functions.axes(grid, x), x, ModeSet::polynomial);
        work(kernels, grid, at, modes, random);
      };
      with(LinearFunctions{});
      with(SplineFunctions<2>{});
      with(SplineFunctions<3>{});
    }
  }
}

void fill_randomly(std::mt19937& random, double* begin, std::size_t count) {
  std::uniform_real_distribution<double> number(-1, 1);
  for (std::size_t i = 0; i < count; ++i) begin[i] = number(random);
}

double product_of(const double* a, const double* b, std::size_t count) {
  double sum = 0;
  for (std::size_t i = 0; i < count; ++i) sum += a[i] * b[i];
  return sum;
}

TYPED_TEST(RowKernel, GivesTheTransposeOfWhatItTakes) {
  constexpr int D = TypeParam::value;
  with_places<D>([](const auto& kernels, const auto& grid, const auto& at, const auto& modes,
                    std::mt19937& random) {
    const detail::NodeList list = detail::list_of(at);
    detail::NodeRows rows(grid.size(), 8), weights(grid.size(), 8);
    std::fill(rows[0], rows[grid.size()], 0.0);
    fill_randomly(random, weights[0], 8 * grid.size());
    detail::Given given{};
    std::vector<double> c(4 * static_cast<std::size_t>(modes.count())), moments(c.size());
    fill_randomly(random, given.value, 4);
    for (int d = 0; d < D; ++d) fill_randomly(random, given.slope[d], 4);
    fill_randomly(random, c.data(), c.size());
    given.modes = {modes.values(), static_cast<std::ptrdiff_t>(modes.nodes()), 1,
                   static_cast<std::size_t>(modes.count())};
    given.coefficients = c.data();
    kernels.give(list, given, rows.data());
    detail::Taken taken;
    kernels.take(list, weights.data(), weights.data() + 4, 8, taken);
    kernels.take_modes(list, given.modes, weights.data(), moments.data());
    double expected =
        product_of(given.value, taken.value, 4) + product_of(c.data(), moments.data(), c.size());
    for (int d = 0; d < D; ++d) expected += product_of(given.slope[d], taken.slope[d], 4);
    EXPECT_NEAR(product_of(rows[0], weights[0], 8 * grid.size()), expected,
                rounding_of_rows * static_cast<double>(c.size()));
  });
}

TYPED_TEST(RowKernel, TakesWhatTheFunctionsSay) {
  constexpr int D = TypeParam::value;
  with_places<D>([](const auto& kernels, const auto& grid, const auto& at, const auto& modes,
                    std::mt19937& random) {
    const detail::NodeList list = detail::list_of(at);
    detail::NodeRows rows(grid.size(), 8), fours(grid.size(), 4);
    fill_randomly(random, rows[0], 8 * grid.size());
    fill_randomly(random, fours[0], 4 * grid.size());
    detail::Taken taken;
    kernels.take(list, rows.data(), fours.data(), 4, taken);
    std::vector<double> moments(4 * static_cast<std::size_t>(modes.count()));
    kernels.take_modes(list,
                       {modes.values(), static_cast<std::ptrdiff_t>(modes.nodes()), 1,
                        static_cast<std::size_t>(modes.count())},
                       rows.data(), moments.data());
    double four[4];
    kernels.take_four(list, fours.data(), four);
    for (std::size_t c = 0; c < 8; ++c)
      EXPECT_NEAR(taken.value[c], at.value([&](std::uint32_t i) { return rows[i][c]; }),
                  rounding_of_rows);
    for (std::size_t c = 0; c < 4; ++c) {
      const auto column = [&](std::uint32_t i) { return fours[i][c]; };
      const SpaceVector<D> slope = at.gradient(column);
      EXPECT_NEAR(four[c], at.value(column), rounding_of_rows);
      for (int d = 0; d < D; ++d) EXPECT_NEAR(taken.slope[d][c], slope[d], rounding_of_rows);
      for (int r = 0; r < modes.count(); ++r) {
        if (modes.norm(r) == 0) continue;
        const double coefficient =
            modes.coefficient(r, at, [&](std::uint32_t i) { return rows[i][c]; });
        EXPECT_NEAR(moments[4 * static_cast<std::size_t>(r) + c], coefficient * modes.norm(r),
                    rounding_of_rows);
      }
    }
  });
}

// Number 7 gets squared sum |G|^2, whether there are modes or not; and four numbers go to rows of
// four with S.
TYPED_TEST(RowKernel, AddsSquaresAndFours) {
  constexpr int D = TypeParam::value;
  with_places<D>([](const auto& kernels, const auto& grid, const auto& at, const auto& modes,
                    std::mt19937& random) {
    const detail::NodeList list = detail::list_of(at);
    detail::NodeRows rows(grid.size(), 8), fours(grid.size(), 4);
    std::fill(rows[0], rows[grid.size()], 0.0);
    std::fill(fours[0], fours[grid.size()], 0.0);
    detail::Given given{};
    given.squared = 0.5;
    kernels.give(list, given, rows.data());
    const std::vector<double> none(4 * static_cast<std::size_t>(modes.count()));
    given.modes = {modes.values(), static_cast<std::ptrdiff_t>(modes.nodes()), 1,
                   static_cast<std::size_t>(modes.count())};
    given.coefficients = none.data();
    kernels.give(list, given, rows.data());
    double four[4];
    fill_randomly(random, four, 4);
    kernels.give_four(list, four, fours.data());
    for (std::size_t k = 0; k < at.size(); ++k) {
      EXPECT_NEAR(rows[at.node[k]][7], at.G[k].squaredNorm(), 1e-13 * at.G[k].squaredNorm());
      for (std::size_t c = 0; c < 7; ++c) EXPECT_EQ(rows[at.node[k]][c], 0);
      for (std::size_t c = 0; c < 4; ++c)
        EXPECT_NEAR(fours[at.node[k]][c], at.S[k] * four[c], 1e-15);
    }
  });
}

}  // namespace
}  // namespace recon::test
