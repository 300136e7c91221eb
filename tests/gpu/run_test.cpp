// Whole runs whose steps are those of a GPU, in loops on the processor, against ordinary ones.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "gpu/stepping.hpp"
#include "gpu/support.hpp"
#include "recon/io/read.hpp"
#include "runs/support.hpp"
#include "support/disk_and_box.hpp"

namespace recon::mpm::test {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

class GpuRun : public InFolder {};

ProblemFile<2> problem(const std::vector<std::string>& settings = {}) {
  return disk_and_box("mpm", settings);
}

RunResult run_on_host(ProblemFile<2> file, const RunOptions& options) {
  file.device = RunDevice::gpu;
  return run_with<2>(make_on_host<2>, std::move(file), options);
}

// The columns of a table are the same to this part of the largest number of each.
void expect_the_same(const fs::path& a, const fs::path& b, double tolerance) {
  const ParticleTable one = read_particles(a), two = read_particles(b);
  ASSERT_EQ(one.size(), two.size()) << a;
  ASSERT_EQ(one.names(), two.names()) << a;
  for (const std::string& name : one.names()) {
    const auto x = one.column(name), y = two.column(name);
    double most = 1e-9;
    for (std::size_t i = 0; i < x.size(); ++i)
      if (std::isfinite(x[i])) most = std::max(most, std::abs(x[i]));
    for (std::size_t i = 0; i < x.size(); ++i) {
      ASSERT_EQ(std::isfinite(x[i]), std::isfinite(y[i])) << a << ", " << name;
      if (std::isfinite(x[i])) {
        ASSERT_NEAR(x[i], y[i], tolerance * most) << a << ", " << name;
      }
    }
  }
}

TEST_F(GpuRun, LeavesWhatAnOrdinaryOneLeaves) {
  for (const std::string method : {"mpm", "affine_cpdi2", "impm"}) {
    const ProblemFile<2> file = problem({"method.name=" + method});
    const fs::path here = folder_ / (method + "_here"), there = folder_ / (method + "_there");
    const RunResult a = run(file, {.folder = here});
    const RunResult b = run_on_host(file, {.folder = there});
    EXPECT_EQ(a.steps, b.steps);
    EXPECT_GT(a.steps, 20);
    EXPECT_EQ(a.frames, b.frames);
    EXPECT_EQ(a.frames, 5u);
    EXPECT_NEAR(a.shortest_step, b.shortest_step, 1e-10 * a.shortest_step);
    EXPECT_EQ(a.limiting_particle, b.limiting_particle);
    for (const auto& each : fs::directory_iterator(here)) {
      const fs::path name = each.path().filename();
      EXPECT_TRUE(fs::exists(there / name)) << name;
      if (name.extension() == ".vtp" || name.extension() == ".csv")
        expect_the_same(each.path(), there / name, 1e-9);
      if (name.extension() == ".pvd") {
        EXPECT_EQ(contents(each.path()), contents(there / name));
      }
    }
  }
}

// Without a ledger the state comes here for frames alone, and the frames are the same.
TEST_F(GpuRun, WithoutALedgerHasTheSameFrames) {
  ProblemFile<2> file = problem();
  run_on_host(file, {.folder = folder_ / "with"});
  file.output.ledger = false;
  file.probes.clear();
  run_on_host(file, {.folder = folder_ / "without"});
  for (int frame = 0; frame < 5; ++frame) {
    const std::string name = "run_particles_000" + std::to_string(frame) + ".vtp";
    EXPECT_TRUE(contents(folder_ / "with" / name) == contents(folder_ / "without" / name)) << name;
  }
}

// From the checkpoint of either to the end by either: four ways, of which two change.
TEST_F(GpuRun, GoesOnFromTheCheckpointOfTheOther) {
  for (const std::string method : {"mpm", "affine_cpdi2", "impm"}) {
    const ProblemFile<2> file = problem({"method.name=" + method});
    const auto by = [&](bool gpu, const RunOptions& options) {
      return gpu ? run_on_host(file, options) : run(file, options);
    };
    const fs::path whole = folder_ / (method + "_whole");
    const RunResult all = run(file, {.folder = whole});
    for (const bool first : {false, true})
      for (const bool second : {false, true}) {
        const fs::path parts =
            folder_ / (method + std::to_string(int{first}) + std::to_string(int{second}));
        int asked = 0;
        RunOptions options{.folder = parts};
        options.stop = [&] { return ++asked == 20; };
        EXPECT_TRUE(by(first, options).stopped);
        const RunResult end = by(second, {.folder = parts, .restart = parts / "checkpoint.h5"});
        EXPECT_EQ(end.steps, all.steps);
        EXPECT_EQ(end.frames, all.frames);
        for (const char* name : {"ledger.csv", "probes.csv", "run_particles_0004.vtp"})
          expect_the_same(whole / name, parts / name, 1e-9);
        if (first == second && first) {
          // To the bit, as if it had not been stopped.
          run_on_host(file, {.folder = folder_ / (method + "_one")});
          EXPECT_TRUE(contents(folder_ / (method + "_one") / "ledger.csv") ==
                      contents(parts / "ledger.csv"));
          EXPECT_TRUE(contents(folder_ / (method + "_one") / "checkpoint.h5") ==
                      contents(parts / "checkpoint.h5"));
        }
      }
  }
}

TEST_F(GpuRun, FailsAsAnOrdinaryOne) {
  const ProblemFile<2> file =
      problem({"time.rule=fixed", "time.step=0.01", "time.end=1", "body.velocity=[30,0.1]"});
  const auto failure = [&](const auto& run) {
    try {
      run();
    } catch (const Failure& failed) {
      return std::string(failed.what());
    }
    return std::string("none");
  };
  const std::string here = failure([&] { run(file, {.folder = folder_ / "here"}); });
  EXPECT_THAT(here, HasSubstr("particle"));
  EXPECT_EQ(here, failure([&] { run_on_host(file, {.folder = folder_ / "there"}); }));
}

// What has no form says which choice it is, and names those that have one.
TEST_F(GpuRun, NamesWhatHasNoForm) {
  const auto refusal = [&](const std::vector<std::string>& settings) {
    try {
      run_on_host(problem(settings), {.folder = folder_ / "out"});
    } catch (const InvalidArgument& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  const auto expect = [&](const std::vector<std::string>& settings, const std::string& argument,
                          const std::string& rule) {
    EXPECT_THAT(refusal(settings), testing::AllOf(HasSubstr(argument), HasSubstr(rule)))
        << settings[0];
    EXPECT_FALSE(fs::exists(folder_ / "out"));
  };
  const std::string none = "has no form for a GPU";
  for (const Method& method : methods()) {
    const auto with = methods_on_gpu();
    if (std::find(with.begin(), with.end(), method.name) != with.end()) continue;
    expect({"method.name=" + method.name}, " of the method", none);
    expect({"method.name=" + method.name}, "mpm, cpdi2", "affine_cpdi2");
  }
  expect({"method.name=cpdi1"}, "domain of the method", "those that have: point, cpdi2");
  expect({"method.name=q9"}, "basis of the method", none);
  expect({"method.name=imls_mpm"}, "velocity of the method", none);
  expect({"method.name=wls"}, "quadrature of the method", none);
  expect({"method.name=impm+degree=2"}, "degree of the method", "those that have: 1");
  expect({"method.name=impm+momentum_correction=true"}, "momentum_correction", none);
  expect({"method.name=impm+negative_mass=stop"}, "negative_mass", none);
  expect({"method.name=impm", "boundary.kind=symmetry"}, "symmetry of a boundary", none);
  expect({"method.name=mpm+mass=consistent"}, "mass of the method", none);
  expect({"method.name=mpm+update=xpic"}, "update of the method", none);
  expect({"method.name=mpm+update=runge_kutta"}, "update of the method", none);
  expect({"grid.periodic=[true,false]"}, "periodic of the grid", none);
  expect({"loads.body_force=[\"x\",0]"}, "body_force", none);
  Problem<2> loaded = problem().problem;
  loaded.loads = {point_load<2>(0, Vector<2>(1, 0), [](double) { return 1.0; })};
  EXPECT_THROW(require_form_on_gpu(loaded), InvalidArgument);
  Problem<2> imaged = problem().problem;
  imaged.boundaries[0].images = true;
  EXPECT_THROW(require_form_on_gpu(imaged), InvalidArgument);
  EXPECT_NO_THROW(require_form_on_gpu(problem().problem));
}

// The key of the problem file; without a GPU the ordinary run refuses it.
TEST_F(GpuRun, IsAskedForInTheProblemFile) {
  EXPECT_EQ(problem().device, RunDevice::cpu);
  EXPECT_EQ(problem({"device=cpu"}).device, RunDevice::cpu);
  const ProblemFile<2> file = problem({"device=gpu"});
  EXPECT_EQ(file.device, RunDevice::gpu);
  EXPECT_THROW(problem({"device=tpu"}), FileError);
  try {
    run(file, {.folder = folder_ / "out"});
    ADD_FAILURE() << "ran on the processor";
  } catch (const InvalidArgument& error) {
    EXPECT_EQ(error.argument(), "device");
  }
}

}  // namespace
}  // namespace recon::mpm::test
