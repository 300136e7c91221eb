// Boundaries between the nodes, and periods: the vibration of the papers where the grid is shifted
// against its walls, and where it has none.
#include <algorithm>
#include <cmath>

#include "recon/studies/convergence.hpp"
#include "recon/studies/errors.hpp"
#include "runs/support.hpp"

namespace recon::mpm::test {
namespace {

// The problem of an example on a grid that begins `shift` cells before the lower corner of the
// body, with images beyond all of its walls.
template <int D>
ProblemFile<D> with_images(ProblemFile<D> file, double shift) {
  Problem<D>& problem = file.problem;
  const Grid<D> plain = problem.grid;
  const double h = plain.h();
  Vector<D> lower = plain.lower(), upper;
  for (int d = 0; d < D; ++d) {
    lower[d] -= (image_cells + shift) * h;
    upper[d] = lower[d] + (plain.cells(d) + 2 * image_cells + (shift > 0 ? 1 : 0)) * h;
  }
  problem.grid = Grid<D>(lower, upper, h);
  for (Boundary<D>& boundary : problem.boundaries) boundary.images = true;
  return file;
}

// The same without walls, for a motion whose period the body is: it lies from `from` on, on a grid
// that begins there.
template <int D>
ProblemFile<D> periodic(ProblemFile<D> file, double from) {
  Problem<D>& problem = file.problem;
  const Grid<D> plain = problem.grid;
  std::array<bool, D> all;
  all.fill(true);
  Vector<D> upper;
  for (int d = 0; d < D; ++d) upper[d] = plain.upper(d) + from;
  problem.grid = periodic_grid<D>(plain.lower().array() + from, upper, plain.h(), all);
  problem.periodic = all;
  problem.boundaries.clear();
  for (auto* places : {&problem.particles.X, &problem.particles.x})
    for (Vector<D>& x : *places) x.array() += from;
  follow(file.exact, problem);
  return file;
}

template <int D, class Change>
std::vector<ConvergenceRow> study(const std::string& name, const ConvergenceStudy& asked,
                                  const Change& change) {
  return converge(
      [&](std::span<const std::string> settings) -> AnyProblem {
        return change(std::get<ProblemFile<D>>(read_problem(example(name), settings)));
      },
      asked);
}

// Orders of displacement and velocity on each pair of the grids but the first. Velocities of these
// four are of less than second order on fine grids with walls on nodes as well: 1.78, 1.78, 1.75 and
// 1.45 between 64 and 128 cells; and in the shorter waves of periods those of affine_cpdi: 1.65.
// Where stresses are asked for, too: not that of wls, 1.26 with walls on nodes.
void expect_second_order(const std::vector<ConvergenceRow>& rows, std::size_t pairs,
                         const std::string& what, bool short_waves = false, bool stress = false) {
  std::vector<std::string> slow{"cpdi1", "cpdi2", "wls", "bspline_mls"};
  if (short_waves) slow.insert(slow.end(), {"affine_cpdi", "affine_cpdi2"});
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const ConvergenceRow& row = rows[i];
    const bool asked = row.field == "displacement" || row.field == "velocity" ||
                       (stress && row.field == "stress" && row.method != "wls");
    if (row.norm != "l2" || !asked) continue;
    if (row.field == "velocity" && std::find(slow.begin(), slow.end(), row.method) != slow.end())
      continue;
    const bool finest = i + 1 == rows.size() || rows[i + 1].cells < row.cells;
    for (std::size_t back = 0; finest && back < pairs; ++back) {
      const ConvergenceRow& each = rows[i - back];
      EXPECT_GE(each.order, 1.75) << what << " " << each.method << " " << each.field << " on "
                                  << each.cells << " cells " << each.failure;
      EXPECT_LE(each.order, 2.3) << what << " " << each.method << " " << each.field << " on "
                                 << each.cells << " cells";
    }
  }
}

// Two pairs of grids, walls 0.37 cells off the nodes.
TEST(ShiftedVibration, IsOfSecondOrderIn1D) {
  const ConvergenceStudy asked{{"cpgimp", "cpdi1", "cpdi2", "impm", "improved_cpdi", "cpls", "wls",
                                "bspline_mls", "affine_cpdi", "affine_cpdi2"},
                               {32, 64, 128},
                               {0.375}};
  expect_second_order(study<1>("vibration_1d.toml", asked,
                               [](ProblemFile<1> file) { return with_images(file, 0.37); }),
                      2, "1-D", false, true);
}

const ConvergenceStudy asked_in_2d{
    {"cpgimp", "cpdi1", "impm", "improved_cpdi", "cpls", "affine_cpdi"}, {16, 32, 64}, {0.375}};

// Two pairs in 2-D as well: walls on all sides, mirrors of mirrors in the corners.
TEST(SlowShiftedVibration, IsOfSecondOrderIn2D) {
  expect_second_order(study<2>("vibration_2d.toml", asked_in_2d,
                               [](ProblemFile<2> file) { return with_images(file, 0.37); }),
                      1, "2-D");
}
// The waves of a period are shorter, and some methods are of less than second order in them on these
// grids, with walls as without: errors are those between walls on nodes, to a tenth.
TEST(SlowPeriodicVibration, HasTheErrorsOfWallsIn2D) {
  const auto rows = [](bool walls) {
    return study<2>("axis_vibration.toml", asked_in_2d, [walls](ProblemFile<2> file) {
      file.exact = make_manufactured<2>("axis_vibration", 0.05,
                                        material_of_exact(file.problem.materials), 1000);
      if (!walls) return periodic(file, 0.1875);
      follow(file.exact, file.problem);
      return file;
    });
  };
  const auto periods = rows(false), walls = rows(true);
  ASSERT_EQ(periods.size(), walls.size());
  int compared = 0;
  for (std::size_t i = 0; i < walls.size(); ++i) {
    if (walls[i].norm != "l2" || walls[i].field == "grid_velocity") continue;
    ASSERT_TRUE(walls[i].failure.empty() && periods[i].failure.empty()) << walls[i].method;
    EXPECT_NEAR(periods[i].error, walls[i].error, 0.1 * walls[i].error)
        << walls[i].method << " " << walls[i].field << " on " << walls[i].cells;
    ++compared;
  }
  EXPECT_EQ(compared, 6 * 3 * 4);  // methods, grids, fields
}

TEST(PeriodicVibration, IsOfSecondOrderIn1D) {
  const ConvergenceStudy asked{{"cpgimp", "cpdi1", "cpdi2", "impm", "improved_cpdi", "cpls", "wls",
                                "bspline_mls", "affine_cpdi", "affine_cpdi2"},
                               {32, 64, 128},
                               {0.375}};
  expect_second_order(study<1>("vibration_1d.toml", asked,
                               [](ProblemFile<1> file) {
                                 file.exact = make_manufactured<1>(
                                     "axis_vibration", 0.05,
                                     material_of_exact(file.problem.materials), 1000);
                                 return periodic(file, 0.1875);
                               }),
                      2, "1-D", true);
}

}  // namespace
}  // namespace recon::mpm::test
