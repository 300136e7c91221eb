// Memory of compile-time size and memory handed in: the same bits as with memory that grows, no
// allocation, and an error where it is too small.
#include "recon/core/memory.hpp"

#include <gtest/gtest.h>

#include "recon/shape/shape_function.hpp"
#include "support/clouds.hpp"
#include "support/count_allocations.hpp"
#include "support/message_of.hpp"

namespace recon::testing {
namespace {

#if !RECON_COUNTS_ALLOCATIONS
constexpr long allocations = 0;
#endif

constexpr int D = 3, most = 150;
using Terms = Monomials<D, 2>;
using Growable = TargetShapes<Terms, BSpline<3>>;
using Fixed = TargetShapes<Terms, BSpline<3>, double, RoomFor<most>>;
using Handed = TargetShapes<Terms, BSpline<3>, double, Given>;

template <class Shapes>
FitReport fit(Shapes& shapes, const PointList<double, D>& points, const std::array<double, D>& x) {
  return shapes.fit(x, 0.7, static_cast<int>(points.size()), [&](int i) {
    std::array<double, D> offset = points[static_cast<std::size_t>(i)];
    for (int d = 0; d < D; ++d) offset[d] -= x[d];
    return offset;
  });
}

template <class Shapes>
void expect_same_bits(const Growable& a, const Shapes& b) {
  ASSERT_EQ(a.size(), b.size());
  for (int p = 0; p < a.size(); ++p) {
    EXPECT_EQ(a.place(p), b.place(p));
    EXPECT_EQ(a.arrays().value[p], b.arrays().value[p]);
    for (int d = 0; d < D; ++d) EXPECT_EQ(a.arrays().gradient[d][p], b.arrays().gradient[d][p]);
    for (int i = 0; i < D * (D + 1) / 2; ++i)
      EXPECT_EQ(a.arrays().hessian[i][p], b.arrays().hessian[i][p]);
  }
}

TEST(Memory, FixedAndHandedInGiveTheSameBitsAndAllocateNothing) {
  static std::array<std::byte, Handed::bytes_for(most)> bytes;
  const std::array<double, D> x{0.4, 0.5, 0.45};
  for (const Solver solver : {Solver::moment_matrix, Solver::gram_schmidt}) {
    Growable growing(BSpline<3>{}, solver);
    const long before = allocations;
    static Fixed fixed(BSpline<3>{}, solver);
    fixed = Fixed(BSpline<3>{}, solver);
    Workspace workspace(bytes);
    Handed handed(BSpline<3>{}, solver, WeightForm::radial, {}, {workspace, most});
    EXPECT_EQ(allocations, before);
    long allocated = 0;
    int clouds = 0;
    for (const auto& cloud : hostile_clouds<double, D>()) {
      if (cloud.points.size() > most) continue;
      ++clouds;
      const FitReport expected = fit(growing, cloud.points, x);
      const long at_first = allocations;
      const FitReport in_fixed = fit(fixed, cloud.points, x),
                      in_given = fit(handed, cloud.points, x);
      allocated += allocations - at_first;
      EXPECT_EQ(in_fixed, expected) << cloud.name;
      EXPECT_EQ(in_given, expected) << cloud.name;
      expect_same_bits(growing, fixed);
      expect_same_bits(growing, handed);
    }
    EXPECT_EQ(allocated, 0);
    EXPECT_GT(clouds, 5);
  }
}

// The same for the solvers by themselves.
TEST(Memory, SolversTakeWhatTheySay) {
  using Fit = GramSchmidt<double, Terms, 2, Given>;
  std::vector<std::byte> bytes(Fit::bytes_for(20));
  Workspace workspace(bytes);
  Fit fit({}, {workspace, 20});
  const auto points = random_points<double, D>(20, 1);
  std::array<std::vector<double>, D> xi;
  for (const auto& x : points)
    for (int d = 0; d < D; ++d) xi[d].push_back(2 * x[d] - 1);
  const std::vector<double> w(20, 1.0);
  LocalCloud<double, D> cloud;
  cloud.size = 20;
  cloud.w = w.data();
  for (int d = 0; d < D; ++d) cloud.xi[d] = xi[d].data();
  const long before = allocations;
  const FitReport report = fit.fit(cloud);
  EXPECT_EQ(allocations, before);
  EXPECT_EQ(report, (GramSchmidt<double, Terms>{}.fit(cloud)));
  EXPECT_EQ(report.rank, 10);
  cloud.size = 19;
  EXPECT_EQ(fit.fit(cloud).neighbours, 19u);
  EXPECT_EQ(message_of([&] { workspace.take<double>(8); }).substr(0, 28),
            "bytes left in the workspace ");
}

TEST(Memory, TooManyParticlesAreRefused) {
  TargetShapes<Monomials<1, 1>, BSpline<1>, double, RoomFor<3>> shapes(BSpline<1>{});
  const auto offset = [](int i) { return std::array<double, 1>{0.1 * i - 0.15}; };
  EXPECT_EQ(shapes.fit({0}, 1, 3, offset).degree, 1);
  const std::string message = message_of([&] { shapes.fit({0}, 1, 4, offset); });
  EXPECT_NE(message.find("must not exceed what RoomFor or Given provide"), std::string::npos)
      << message;
  EXPECT_EQ(shapes.fit({0}, 1, 2, offset).degree, 1);
  std::array<std::byte, 16> few;
  Workspace workspace(few);
  EXPECT_NE(message_of([&] {
              GramSchmidt<double, Terms, 2, Given>({}, {workspace, 3});
            }).find("bytes left in the workspace = 16: must suffice"),
            std::string::npos);
}

// Copies are values, but with memory handed in they share it.
TEST(Memory, CopiesKeepTheirResults) {
  Growable shapes(BSpline<3>{});
  const auto points = random_points<double, D>(60, 4);
  fit(shapes, points, {0.5, 0.5, 0.5});
  const Growable copy = shapes;
  const double first = copy.arrays().value[0];
  fit(shapes, points, {0.3, 0.6, 0.5});
  EXPECT_EQ(copy.arrays().value[0], first);
  EXPECT_NE(shapes.arrays().value[0], first);
}

}  // namespace
}  // namespace recon::testing
