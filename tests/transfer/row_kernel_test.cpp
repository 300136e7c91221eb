// Sums between a particle and rows of nodes: what it gives is the transpose of what it takes, and
// this is what NodeFunctions say, with every instruction set, of lists, products and corners.
#include <cmath>

#include "recon/transfer/domain_functions.hpp"
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

// Without lists of nodes there are the same sums: `other` is what takes the place of the list of
// `at`, and `modes` are the affine ones where it has some.
template <int D, class Nodes, class Other>
void expect_same_sums(const detail::RowKernels<D>& kernels, const CartesianGrid<D>& grid,
                      const Nodes& at, const Other& other, const detail::ModeList& modes,
                      bool with_squares, std::mt19937& random) {
  const detail::NodeList list = detail::list_of(at);
  detail::Given given{};
  std::vector<double> c(4 * std::max<std::size_t>(1, modes.count)), moments(c.size());
  fill_randomly(random, c.data(), c.size());
  fill_randomly(random, given.value, 4);
  for (int d = 0; d < D; ++d) fill_randomly(random, given.slope[d], 3);
  given.squared = with_squares ? 0.5 : 0;
  given.modes = modes;
  given.coefficients = c.data();
  const auto given_by = [&](const auto& by) {
    detail::NodeRows rows(grid.size(), 8), fours(grid.size(), 4);
    std::fill(rows[0], rows[grid.size()], 0.0);
    std::fill(fours[0], fours[grid.size()], 0.0);
    kernels.give(by, given, rows.data());
    kernels.give_four(by, given.value, fours.data());
    std::vector<double> all(rows[0], rows[grid.size()]);
    all.insert(all.end(), fours[0], fours[grid.size()]);
    return all;
  };
  detail::NodeRows rows(grid.size(), 8), fours(grid.size(), 4);
  fill_randomly(random, rows[0], 8 * grid.size());
  fill_randomly(random, fours[0], 4 * grid.size());
  const auto taken_by = [&](const auto& by) {
    std::vector<double> all(4);
    kernels.take_four(by, fours.data(), all.data());
    for (const bool same : {true, false}) {
      detail::Taken taken;
      kernels.take(by, rows.data(), same ? rows.data() : fours.data(), same ? 8 : 4, taken);
      all.insert(all.end(), taken.value, taken.value + 8);
      for (int d = 0; d < D; ++d) all.insert(all.end(), taken.slope[d], taken.slope[d] + 4);
      if (modes.count == 0) continue;
      kernels.take_modes(list, modes, rows.data(), moments.data());
      if constexpr (std::is_same_v<std::decay_t<decltype(by)>, detail::ProductList>)
        for (int d = 0; d < D; ++d) std::copy_n(taken.moment[d], 4, &moments[4 * d]);
      all.insert(all.end(), moments.begin(), moments.end());
    }
    return all;
  };
  const double most_slope = 1 / (grid.h() * grid.h());  // of the squares
  const auto expect_near = [&](const std::vector<double>& one, const std::vector<double>& two) {
    ASSERT_EQ(one.size(), two.size());
    for (std::size_t i = 0; i < one.size(); ++i)
      EXPECT_NEAR(one[i], two[i], rounding_of_rows * most_slope) << i;
  };
  expect_near(given_by(other), given_by(list));
  expect_near(taken_by(other), taken_by(list));
}

TYPED_TEST(RowKernel, ProductsNeedNoList) {
  constexpr int D = TypeParam::value;
  const CartesianGrid<D> grid = unit_grid<D>(5);
  for (const InstructionSet set : available_instruction_sets()) {
    SCOPED_TRACE(name_of(set));
    const detail::RowKernels<D> kernels(set);
    std::mt19937 random(4);
    for (int round = 0; round < 20; ++round) {
      const SpaceVector<D> x = random_point<D>(random);
      const auto with = [&](const auto& functions) {
        typename std::decay_t<decltype(functions)>::template Nodes<D> at;
        functions.at(grid, x, at);
        const auto axes = functions.axes(grid, x);
        detail::ProductList product = detail::product_of<D>(grid, axes);
        for (const bool squares : {true, false})
          expect_same_sums<D>(kernels, grid, at, product, {}, squares, random);
        PolynomialModes<D> modes;
        modes.fill(grid, axes, x, ModeSet::affine);
        std::array<std::array<double, 4>, D> along;
        for (int d = 0; d < D; ++d) {
          const auto of_axis = detail::modes_of_axis(grid, axes[d], x[d], d, false);
          for (int k = 0; k < axes[d].count; ++k) along[d][k] = axes[d].S[k] * of_axis.value[1][k];
          product.M[d] = along[d].data();
        }
        const detail::ModeList list{modes.values(), static_cast<std::ptrdiff_t>(modes.nodes()), 1,
                                    static_cast<std::size_t>(modes.count())};
        for (const bool squares : {true, false})
          expect_same_sums<D>(kernels, grid, at, product, list, squares, random);
      };
      with(LinearFunctions{});
      with(SplineFunctions<2>{});
      with(SplineFunctions<3>{});
      BoxDomain<D> box{x, {}};
      for (int d = 0; d < D; ++d) box.half_edges[d] = (0.1 + 0.5 * d) * grid.h();
      GimpFunctions::Nodes<D> at;
      GimpFunctions::at(grid, box, at);
      GimpFunctions::Axes<D> axes;
      GimpFunctions::write_axes<D>(grid, box, axes);
      expect_same_sums<D>(kernels, grid, at, detail::product_of<D>(grid, axes), {}, false, random);
    }
  }
}

// Also of corners beyond the grid, where linear functions go on.
TYPED_TEST(RowKernel, CornersNeedNoList) {
  constexpr int D = TypeParam::value;
  const CartesianGrid<D> grid = unit_grid<D>(5);
  for (const InstructionSet set : available_instruction_sets()) {
    SCOPED_TRACE(name_of(set));
    const detail::RowKernels<D> kernels(set);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> shift(-0.05, 0.05);
    for (int round = 0; round < 20; ++round) {
      const SpaceVector<D> x = random_point<D>(random);
      ParallelepipedDomain<D> domain{x, SpaceMatrix<D>::Identity() * 0.1};
      for (double& entry : domain.half_edges.reshaped()) entry += shift(random);
      const auto with = [&](const auto& of, const auto& at) {
        detail::CornerList list;
        kernels.find(grid, of, list);
        expect_same_sums<D>(kernels, grid, at, list, {}, false, random);
      };
      Cpdi1Functions::Nodes<D> at;
      Cpdi1Functions::at(grid, domain, at);
      with(domain, at);
      const CornerDomain<D> corners(corners_of(domain));
      Cpdi2Functions::at(grid, corners, at);
      with(corners, at);
    }
    ParallelepipedDomain<D> domain{SpaceVector<D>::Constant(0.5), SpaceMatrix<D>::Identity() * 0.1};
    CornerDomain<D> corners(corners_of(domain));
    detail::CornerList list;
    EXPECT_NO_THROW(kernels.find(grid, domain, list));
    EXPECT_NO_THROW(kernels.find(grid, corners, list));
    domain.x[D - 1] = corners.corners[1][D - 1] = std::nan("");
    EXPECT_THROW(kernels.find(grid, domain, list), InvalidArgument);
    EXPECT_THROW(kernels.find(grid, corners, list), InvalidArgument);
  }
}

}  // namespace
}  // namespace recon::test
