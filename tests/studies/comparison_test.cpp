// All methods on one problem: what runs, what is refused, and what the rows say.
#include "recon/studies/comparison.hpp"

#include <cmath>

#include "runs/support.hpp"

namespace recon::mpm::test {
namespace {

LoadProblem example_with(const std::string& name, std::vector<std::string> more) {
  return [=](std::span<const std::string> settings) {
    std::vector<std::string> all = more;
    all.insert(all.end(), settings.begin(), settings.end());
    return read_problem(example(name), all);
  };
}

std::vector<std::string> all_names() {
  std::vector<std::string> names;
  for (const Method& method : methods()) names.push_back(method.name);
  return names;
}

const ComparisonRow& row_of(const std::vector<ComparisonRow>& rows, const std::string& method) {
  const auto found =
      std::find_if(rows.begin(), rows.end(), [&](const auto& row) { return row.method == method; });
  EXPECT_NE(found, rows.end()) << method;
  return *found;
}

// Every method begins every example, or is refused for a reason that names what does not fit.
// Elements may break at once where bodies fill them in part: their masses pass through zero.
TEST(Comparison, EveryMethodRunsEveryProblemOrSaysWhyNot) {
  for (const auto& entry : std::filesystem::directory_iterator(example(""))) {
    if (entry.path().extension() != ".toml") continue;
    const std::string name = entry.path().filename().string();
    for (const Method& method : methods()) {
      const std::string settings[] = {"method.name=" + method.name};
      try {
        std::visit(
            [](auto file) {
              Simulation simulation(file.problem);
              simulation.step(simulation.choose_step().dt / 10);
              simulation.map();
              for (const auto& v : simulation.nodes().mapped) EXPECT_TRUE(v.allFinite());
            },
            read_problem(example(name), settings));
      } catch (const Failure& failure) {
        EXPECT_TRUE(method.basis == Basis::q9 || method.basis == Basis::q8)
            << name << ", " << method.name << ": " << failure.what();
      } catch (const FileError& refusal) {
        const std::string what = refusal.what();
        EXPECT_NE(what.find("method"), std::string::npos) << name << ", " << what;
        const bool elements = method.basis == Basis::q8 || method.basis == Basis::q9;
        EXPECT_TRUE(elements || method.update != Update::flip) << name << ", " << what;
      }
    }
  }
}

// A linear stage of the same problem, small deformation: the balance of energy closes up to the
// leapfrog's error, and what conserves by construction has no defect.
TEST(Comparison, RowsSayWhatIsConserved) {
  const auto rows =
      compare(example_with("vibration_2d.toml", {"G=0.001", "end=0.005", "threads=1"}),
              {all_names(), {8, 16}, false});
  ASSERT_EQ(rows.size(), methods().size());
  for (const ComparisonRow& row : rows) {
    EXPECT_TRUE(row.refusal.empty()) << row.method << ": " << row.refusal;
    EXPECT_TRUE(std::isnan(row.stable));
    if (row.method == "q8") {
      EXPECT_GT(row.negative_nodes, 0u);
      continue;
    }
    ASSERT_TRUE(row.failure.empty()) << row.method << ": " << row.failure;
    EXPECT_GT(row.displacement_order, 1.2) << row.method;
    EXPECT_GT(row.velocity_order, 1.5) << row.method;
    EXPECT_GT(row.nanoseconds, 0) << row.method;
    EXPECT_LE(std::abs(row.energy_error), 0.2) << row.method;
    const Method& method = method_named(row.method);
    const bool fitted =
        method.velocity == VelocityMap::mls || method.velocity == VelocityMap::imls ||
        method.velocity == VelocityMap::cpls || method.quadrature == Quadrature::gauss_cells;
    if (fitted)
      EXPECT_GT(row.momentum_defect, 1e-8) << row.method;
    else
      EXPECT_LE(row.momentum_defect, 1e-10) << row.method;
  }
}

// A row for each courant number, methods in the order asked for, and each the row of the problem with
// that number in its file.
TEST(Comparison, ARowForEachCourantNumber) {
  const char* file = "vibration_1d.toml";
  ComparisonStudy study{{"mpm", "cpdi1"}, {16, 32}, false};
  study.courants = {0.4, 0.2};
  const auto rows = compare(example_with(file, {"end=0.007", "threads=1"}), study);
  ASSERT_EQ(rows.size(), 4u);
  for (std::size_t r = 0; r < 4; ++r) {
    EXPECT_EQ(rows[r].method, study.methods[r / 2]);
    EXPECT_EQ(rows[r].courant, study.courants[r % 2]);
    const std::string courant = r % 2 == 0 ? "courant=0.4" : "courant=0.2";
    const auto own = compare(example_with(file, {"end=0.007", "threads=1", courant}),
                             {{rows[r].method}, study.cells, false});
    EXPECT_TRUE(std::isnan(own.front().courant));
    EXPECT_EQ(rows[r].displacement_error, own.front().displacement_error);
    EXPECT_EQ(rows[r].velocity_order, own.front().velocity_order);
  }
  EXPECT_NE(rows[0].displacement_error, rows[1].displacement_error);
}

// The balance of energy counts the work of gravity: a block in free fall.
TEST(Comparison, GravityDoesWork) {
  const std::string text =
      "[grid]\nlower = [0, 0]\nupper = [1, 2]\ncells = 8\n"
      "[material]\nyoung = 1000\npoisson = 0.3\ndensity = 1000\n"
      "[[body]]\nshape = \"box\"\nlower = [0.25, 1.25]\nupper = [0.75, 1.75]\n"
      "[loads]\ngravity = [0, -1]\n[method]\nname = \"mpm\"\n[time]\nend = 1\n";
  const auto rows = compare(
      [&](std::span<const std::string> settings) {
        return read_problem_text(text, "fall.toml", settings);
      },
      {{"mpm", "cpdi1", "cpls", "apic"}, {8}, false});
  for (const ComparisonRow& row : rows) {
    ASSERT_TRUE(row.failure.empty() && row.refusal.empty()) << row.failure << row.refusal;
    EXPECT_NEAR(row.displacement, 0.5, 0.02) << row.method;
    EXPECT_LE(std::abs(row.energy_error), 1e-9) << row.method;
    EXPECT_TRUE(std::isnan(row.angular_error)) << row.method;  // gravity turns about the origin
    EXPECT_TRUE(std::isnan(row.displacement_error)) << row.method;
  }
}

// Angular momentum stays with apic and mls_mpm, and is lost by xpic; mpm fails, with its reason.
TEST(Comparison, ASpinningDiskKeepsItsAngularMomentum) {
  const auto rows = compare(example_with("spin.toml", {"end=1.5", "threads=1"}),
                            {{"apic", "mls_mpm", "xpic", "mpm", "q8"}, {10}, false});
  EXPECT_LE(row_of(rows, "apic").angular_error, 1e-8);
  EXPECT_LE(row_of(rows, "mls_mpm").angular_error, 1e-8);
  EXPECT_GE(row_of(rows, "xpic").angular_error, 1e-3);
  EXPECT_TRUE(std::isnan(row_of(rows, "apic").displacement_before));  // one grid
  const auto refused = compare(example_with("vibration_1d.toml", {}), {{"q8"}, {8}, false});
  EXPECT_NE(refused.front().refusal.find("2-D"), std::string::npos) << refused.front().refusal;
  EXPECT_TRUE(std::isnan(refused.front().nanoseconds));
}

}  // namespace
}  // namespace recon::mpm::test
