// Orders of convergence at large deformation: what the papers claim, on short studies.
#include "recon/studies/convergence.hpp"

#include <cmath>

#include "runs/support.hpp"

namespace recon::mpm::test {
namespace {

std::vector<ConvergenceRow> study(const std::string& file, const ConvergenceStudy& study) {
  return converge(
      [&](std::span<const std::string> settings) { return read_problem(example(file), settings); },
      study);
}

// Of the two finest grids, where errors are nearest to their law.
double finest_order(const std::vector<ConvergenceRow>& rows, const std::string& method,
                    const std::string& field, const std::string& norm, double time) {
  double order = std::nan("");
  for (const ConvergenceRow& row : rows)
    if (row.method == method && row.field == field && row.norm == norm &&
        std::abs(row.time - time) < 1e-9 * time)
      order = row.order;  // cells ascend
  return order;
}

// Second order in displacement and velocity for the improved methods, where the original one does
// not converge (Gong 2015, figures 4.8, 5.6, 6.4; Tran et al. 2019, figures 10, 12).
void expect_orders(const std::string& file, std::vector<int> cells,
                   std::vector<double> times = {0.375, 1}) {
  const ConvergenceStudy asked{{"mpm", "impm", "improved_cpdi", "cpls"}, cells, times};
  const auto rows = study(file, asked);
  const double end = rows.back().time / times.back();
  for (const double part : asked.times)
    for (const char* norm : {"l2", "rms"})
      for (const char* field : {"displacement", "velocity"}) {
        for (const char* method : {"impm", "improved_cpdi", "cpls"})
          EXPECT_GE(finest_order(rows, method, field, norm, part * end), 1.75)
              << file << " " << method << " " << field << " " << norm << " at " << part << " T";
        EXPECT_FALSE(finest_order(rows, "mpm", field, norm, part * end) > 0.8)
            << file << " " << field << " " << norm << " at " << part << " T";
      }
}
// On finer grids, and in 3-D; the ring and the vortex (Tran et al. 2019, figures 24-28, 43-45).
TEST(SlowConvergence, LargeDeformation) {
  expect_orders("vibration_1d.toml", {128, 256});
  expect_orders("vibration_2d.toml", {32, 64});
  expect_orders("vibration_2d.toml", {64, 128});
  const auto cube = study("vibration_3d.toml", {{"impm", "cpls"}, {12, 24}, {0.375}});
  for (const char* method : {"impm", "cpls"})
    for (const char* field : {"displacement", "velocity"})
      EXPECT_GE(finest_order(cube, method, field, "l2", 0.375 * 0.02), 1.75)
          << method << " " << field;
}
TEST(SlowConvergence, RingAndVortex) {
  const auto ring = study("ring.toml", {{"cpls"}, {20, 40, 80}, {1}});
  const auto vortex = study("vortex.toml", {{"cpls"}, {16, 32, 64}, {1}});
  for (const char* field : {"displacement", "velocity"}) {
    EXPECT_GE(finest_order(ring, "cpls", field, "rms", 0.02), 1.75) << field;
    EXPECT_GE(finest_order(vortex, "cpls", field, "rms", 1), 1.75) << field;
  }
}

TEST(Convergence, LargeDeformationIn1D) {
  expect_orders("vibration_1d.toml", {64, 128});
}
// One wave along x in a square is the wave of a bar (Tran et al. 2019, section 4.2): maps and forces
// are products of those of the axes, so that errors are the same up to rounding. (Not so with cpls,
// which fits to 2^D corners and one centre: the corners count for more in a square. The stress
// across the wave has errors of its own, which the bar does not have.)
TEST(Convergence, OneWaveInASquareIsThatOfABar) {
  const auto waves = [](const std::string& file, const std::string& solution) {
    return converge(
        [&](std::span<const std::string> settings) {
          std::vector<std::string> all(settings.begin(), settings.end());
          all.insert(all.end(), {"solution=" + solution, "particles=2"});
          return read_problem(example(file), all);
        },
        {{"cpgimp", "cpdi1"}, {8, 16}, {0.25, 1}});
  };
  const auto bar = waves("vibration_1d.toml", "axis_vibration"),
             square = waves("axis_vibration.toml", "wave_along_x");
  ASSERT_EQ(bar.size(), square.size());
  int compared = 0;
  for (std::size_t i = 0; i < bar.size(); ++i) {
    ASSERT_EQ(bar[i].field, square[i].field);
    if (bar[i].field == "stress") continue;
    ++compared;
    EXPECT_NEAR(square[i].error, bar[i].error, 1e-9 * bar[i].error)
        << bar[i].method << " " << bar[i].field << " " << bar[i].norm << " on " << bar[i].cells;
  }
  EXPECT_GE(compared, 2 * 2 * 2 * 3);  // methods, grids, times, fields in at least one norm
}

// A quarter of the ring between planes of symmetry: of second order also in the stress, at T (Tran
// et al. 2019, section 4.3), and with the errors of the full ring, which are the same in each of
// its quarters. Its domains at the planes are chords, so that the errors differ by a little.
TEST(Convergence, AQuarterOfARing) {
  const ConvergenceStudy asked{{"cpls"}, {20, 40}, {1}};
  const auto quarter = study("quarter_ring.toml", asked), full = study("ring.toml", asked);
  for (const char* field : {"displacement", "velocity", "stress"})
    EXPECT_GE(finest_order(quarter, "cpls", field, "rms", 0.02), 1.75) << field;
  ASSERT_EQ(quarter.size(), full.size());
  for (std::size_t i = 0; i < full.size(); ++i)
    if (full[i].norm == "rms") {
      EXPECT_NEAR(quarter[i].error, full[i].error, 0.01 * full[i].error) << full[i].field;
    }
}
// Whatever is of second order in the full ring, of any method, is so between planes of symmetry, with
// errors that are no larger, by a tenth; those of splines, which are one-sided at planes of nodes,
// by a quarter. Elements are left out, whose functions are negative, and hopic, which takes minutes.
TEST(SlowConvergence, AQuarterOfARingOfEveryMethod) {
  ConvergenceStudy asked{{}, {20, 40}, {1}};
  for (const Method& method : methods())
    if (!is_element(method.basis) && method.degree < 3) asked.methods.push_back(method.name);
  const auto quarter = study("quarter_ring.toml", asked), full = study("ring.toml", asked);
  ASSERT_EQ(quarter.size(), full.size());
  int of_second_order = 0;
  for (std::size_t i = 0; i < full.size(); ++i) {
    if (full[i].norm != "rms" || full[i].field == "grid_velocity" || !(full[i].order >= 1.8))
      continue;
    ++of_second_order;
    EXPECT_GE(quarter[i].order, 1.75) << full[i].method << " " << full[i].field;
    const Basis basis = method_named(full[i].method).basis;
    const bool one_sided = basis == Basis::bspline2 || basis == Basis::bspline3;
    EXPECT_LE(quarter[i].error, (one_sided ? 1.25 : 1.1) * full[i].error)
        << full[i].method << " " << full[i].field;
  }
  EXPECT_GE(of_second_order, 5 * 3);  // five methods, and three fields of each
}
// With images beyond these planes a quarter is the ring itself: domains, splines and fits see what
// they see there. Not wls, in which any rounding grows, and bspline_mls to what fits in cells lack
// that lie two beyond the plane: they reach farther than images.
TEST(Convergence, AQuarterOfARingWithImagesIsTheRing) {
  ConvergenceStudy asked{{}, {20}, {0.25}};
  for (const Method& method : methods())
    if (!is_element(method.basis) && method.degree < 3 &&
        method.velocity != VelocityMap::polynomial && method.name != "wls")
      asked.methods.push_back(method.name);
  const auto mirrored = converge(
      [&](std::span<const std::string> settings) -> AnyProblem {
        auto file = std::get<ProblemFile<2>>(read_problem(example("quarter_ring.toml"), settings));
        Problem<2>& problem = file.problem;
        const Grid<2> plain = problem.grid;
        const Vector<2> more = Vector<2>::Constant(image_cells * plain.h());
        problem.grid =
            Grid<2>(plain.lower() - more, Vector<2>::Constant(plain.upper(0)), plain.h());
        for (Boundary<2>& boundary : problem.boundaries) {
          boundary.images = true;
          boundary.symmetry = false;
        }
        return file;
      },
      asked);
  const auto full = study("ring.toml", asked);
  ASSERT_EQ(mirrored.size(), full.size());
  for (std::size_t i = 0; i < full.size(); ++i) {
    if (full[i].norm != "rms" || full[i].field == "grid_velocity") continue;
    EXPECT_EQ(mirrored[i].failure.empty(), full[i].failure.empty()) << full[i].method;
    const double bound = full[i].method == "bspline_mls" ? 1e-4 : 1e-6;
    EXPECT_NEAR(mirrored[i].error, full[i].error, bound * full[i].error)
        << full[i].method << " " << full[i].field;
  }
}
// At T the velocity of impm is near its order on finer grids only: see the slow test.
TEST(Convergence, LargeDeformationIn2D) {
  expect_orders("vibration_2d.toml", {16, 32}, {0.375});
}

// All methods are of second order in displacement where nothing crosses a cell (Gong 2015,
// figure 4.7). q9 before T, when errors cancel on its four elements of 8 cells.
TEST(Convergence, SmallDeformation) {
  ConvergenceStudy asked;
  for (const Method& method : methods())
    if (method.basis == Basis::q8)
      EXPECT_THROW(method.validate(1), InvalidArgument) << method.name;
    else
      asked.methods.push_back(method.name);
  asked.cells = {8, 16, 32};
  asked.times = {0.375, 1};
  const auto rows = converge(
      [](std::span<const std::string> settings) {
        std::vector<std::string> all(settings.begin(), settings.end());
        all.push_back("G=0.0001");
        return read_problem(example("vibration_1d.toml"), all);
      },
      asked);
  for (const std::string& method : asked.methods)
    EXPECT_GE(slope(rows, method, "displacement", "l2", method == "q9" ? 0.0075 : 0.02), 1.8)
        << method;
}

// The velocities of the nodes, of the particles' time: of second order with fits of degree 1.
TEST(Convergence, VelocitiesOfTheGrid) {
  const auto rows = study("vibration_1d.toml", {{"improved_cpdi", "cpls"}, {32, 64}, {0.375}});
  for (const char* method : {"improved_cpdi", "cpls"})
    for (const char* norm : {"l2", "rms"}) {
      const double order = finest_order(rows, method, "grid_velocity", norm, 0.375 * 0.02);
      EXPECT_GE(order, 1.75) << method << norm;
      EXPECT_LE(order, 2.5) << method << norm;
    }
}

// A fit of degree 1 takes velocities that are linear to the nodes as they are; what the motion's is
// not is seen. Without the nodes of this time there is no error.
TEST(Convergence, AnErrorOfTheGridNeedsItsNodes) {
  auto file = read_example<1>("vibration_1d.toml", {"name=improved_cpdi"});
  Simulation<1> simulation(file.problem);
  EXPECT_THROW(grid_velocity_error(simulation, *file.exact), InvalidArgument);
  simulation.map();
  const double exact = grid_velocity_error(simulation, *file.exact).l2;
  Problem<1> shifted = file.problem;
  for (auto& v : shifted.particles.v) v[0] += 3;
  shifted.boundaries.clear();
  Simulation<1> moved(shifted);
  moved.map();
  const FieldError error = grid_velocity_error(moved, *file.exact);
  double mass = 0;
  for (const double each : shifted.particles.mass) mass += each;
  EXPECT_EQ(error.field, "grid_velocity");
  EXPECT_NEAR(error.rms, 3, exact + 0.1);
  EXPECT_NEAR(error.l2, 3 * std::sqrt(mass / shifted.densities[0]), exact + 0.1);
}

// The bookkeeping: orders follow from errors, rows are complete, failures are rows with a reason.
TEST(Convergence, RowsAndFailures) {
  const auto rows = study("vibration_1d.toml", {{"cpls", "mpm"}, {8, 16}, {0.5, 1}});
  EXPECT_EQ(rows.size(), 2u * 2 * 2 * 5 * 2);
  for (std::size_t i = 0; i + 1 < rows.size(); i += 2) {
    EXPECT_EQ(rows[i].cells, 8);
    EXPECT_EQ(rows[i + 1].cells, 16);
    EXPECT_EQ(rows[i].field, rows[i + 1].field);
    EXPECT_TRUE(std::isnan(rows[i].order));
    EXPECT_NEAR(rows[i + 1].order, std::log2(rows[i].error / rows[i + 1].error), 1e-12);
  }
  const auto failed = converge(
      [](std::span<const std::string> settings) {
        std::vector<std::string> all(settings.begin(), settings.end());
        all.insert(all.end(), {"courant=1.6", "G=0.1"});
        return read_problem(example("vibration_1d.toml"), all);
      },
      {{"mpm"}, {64}, {0.01, 1}});
  for (const ConvergenceRow& row : failed) {
    if (row.time < 0.001) continue;
    EXPECT_TRUE(std::isnan(row.error));
    EXPECT_NE(row.failure.find("particle"), std::string::npos) << row.failure;
  }
}

}  // namespace
}  // namespace recon::mpm::test
