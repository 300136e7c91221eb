// Problem files and their mistakes, runs, restarts.
#include <gmock/gmock.h>
#include <stdlib.h>

#include <cstring>
#include <fstream>
#include <sstream>
#include <thread>

#include "recon/io/read.hpp"
#include "recon/runs/compose.hpp"
#include "recon/runs/run.hpp"
#include "runs/support.hpp"

namespace recon::mpm::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class MpmFiles : public InFolder {
 protected:
  std::string message(const std::string& text, std::vector<std::string> settings = {}) const {
    std::ofstream(folder_ / "p.toml") << text;
    try {
      read_problem(folder_ / "p.toml", settings);
    } catch (const FileError& error) {
      return error.what();
    }
    return "";
  }
};

const std::string good = R"(title = "a block"
[grid]
lower = [0.0, 0.0]
upper = [1.0, 1.0]
cells = 10
[material]
young = 1000
poisson = 0.3
density = 1000
[[body]]
shape = "box"
lower = [0.2, 0.2]
upper = [0.4, 0.4]
velocity = [0.1, "0.1 * X"]
[[boundary]]
axis = "x"
at = 0
kind = "fixed"
[method]
name = "cpls"
[time]
end = 0.5
)";

std::string with(const std::string& from, const std::string& to) {
  std::string text = good;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST_F(MpmFiles, AProblemIsRead) {
  EXPECT_EQ(message(good), "");
  const auto file = std::get<ProblemFile<2>>(read_problem(folder_ / "p.toml"));
  const Problem<2>& problem = file.problem;
  EXPECT_EQ(problem.particles.size(), 16u);
  EXPECT_EQ(problem.method.name, "cpls");
  EXPECT_NEAR(problem.particles.v[0][1], 0.1 * problem.particles.X[0][0], 1e-15);
  EXPECT_NEAR(problem.particles.L[0](1, 0), 0.1, 1e-9);
  EXPECT_EQ(problem.particles.L[0](0, 0), 0);
  double mass = 0;
  for (const double m : problem.particles.mass) mass += m;
  EXPECT_NEAR(mass, 1000 * 0.04, 1e-10);
}

TEST_F(MpmFiles, SettingsNameConstants) {
  const std::string text = with("\"0.1 * X\"", "\"A * X\"") + "[constants]\nA = 0.1\n";
  const std::string settings[] = {"constants.A=3"};
  const auto file = std::get<ProblemFile<2>>(read_problem_text(text, "p.toml", settings));
  const Particles<2>& particles = file.problem.particles;
  EXPECT_NEAR(particles.v[0][1], 3 * particles.X[0][0], 1e-14);
  EXPECT_THAT(message(text, {"constants.B=3"}), HasSubstr("unknown key"));
}

TEST_F(MpmFiles, MistakesNameFileLineKeyAndChoices) {
  EXPECT_THAT(message(with("cells = 10", "")), HasSubstr("p.toml:2: grid.cells: is missing"));
  EXPECT_THAT(message(with("cells = 10", "cells = 10\ncolour = 3")),
              AllOf(HasSubstr("p.toml:6: grid.colour: unknown key")));
  EXPECT_THAT(message(with("\"cpls\"", "\"cpsl\"")),
              AllOf(HasSubstr("method.name: unknown 'cpsl'"), HasSubstr("cpls")));
  EXPECT_THAT(message(with("\"cpls\"", "\"xpic\"\nstress = \"first\"")),
              AllOf(HasSubstr("stress of the method = first: needs"), HasSubstr("update is xpic")));
  EXPECT_THAT(message(with("\"box\"", "\"bxo\"")),
              AllOf(HasSubstr("p.toml:11: body 1.shape"), HasSubstr("box")));
  EXPECT_THAT(message(with("young = 1000", "young = \"stiff\"")),
              HasSubstr("p.toml:7: material.young: a number is needed, not a string"));
  EXPECT_THAT(message(with("young = 1000", "young = -3")), HasSubstr("must be positive"));
  EXPECT_THAT(message(with("poisson = 0.3", "poisson = 0.5")),
              AllOf(HasSubstr("p.toml:8: material.poisson: "), HasSubstr("between -1 and 0.5")));
  EXPECT_THAT(message(with("young = 1000", "young = nan")), HasSubstr("must be finite"));
  EXPECT_THAT(message(with("lower = [0.2, 0.2]", "lower = [0.2]")),
              HasSubstr("p.toml:12: body 1.lower: 2 values are needed"));
  EXPECT_THAT(message(with("lower = [0.2, 0.2]", "lower = [0.5, 0.2]")), HasSubstr("above lower"));
  EXPECT_THAT(message(with("\"0.1 * X\"", "\"0.1 * Q\"")),
              AllOf(HasSubstr("p.toml:14: body 1.velocity"), HasSubstr("Q")));
  EXPECT_THAT(message(with("\"0.1 * X\"", "\"1 / (X - X)\"")), HasSubstr("not finite"));
  EXPECT_THAT(message(with("at = 0", "at = 0.05")), HasSubstr("plane of nodes"));
  EXPECT_THAT(message(with("axis = \"x\"", "axis = \"z\"")), HasSubstr("'x' or 'y'"));
  EXPECT_THAT(message(with("end = 0.5", "end = 0")),
              HasSubstr("time.end: end = 0: must be positive"));
  EXPECT_THAT(message(with("upper = [1.0, 1.0]", "upper = [1.03, 1.0]")),
              HasSubstr("whole number of cells"));
  EXPECT_THAT(message(with("[grid]", "[grid")), HasSubstr("p.toml:2"));
  EXPECT_THAT(message(with("[[body]]", "[body]")), HasSubstr("[[body]]"));
  EXPECT_THAT(message(with("lower = [0.0, 0.0]", "lower = 0.0")), HasSubstr("one for each axis"));
  EXPECT_THAT(message(with("lower = [0.2, 0.2]\nupper = [0.4, 0.4]",
                           "lower = [0.21, 0.21]\nupper = [0.22, 0.22]")),
              HasSubstr("no particle"));
  EXPECT_THAT(message(good + "[loads]\ngravity = [0, -1, 0]\n"), HasSubstr("loads.gravity"));
  try {
    read_problem(folder_ / "none.toml");
    FAIL();
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), HasSubstr("no such file"));
  }
}

// What nobody knows is named before what is missing, which may be the same slip.
TEST_F(MpmFiles, TheUnknownIsNamedFirst) {
  EXPECT_THAT(message(with("cells = 10", "cell = 10")),
              HasSubstr("p.toml:5: grid.cell: unknown key; did you mean 'cells'"));
  EXPECT_THAT(message(with("[grid]", "[gird]")),
              HasSubstr("p.toml:2: gird: unknown key; did you mean 'grid'"));
  EXPECT_THAT(message(with("[time]\nend", "[time]\nfin")), HasSubstr("p.toml:22: time.fin"));
  EXPECT_THAT(message(with("velocity = [", "speed = [")), HasSubstr("p.toml:14: body.speed"));
  EXPECT_THAT(message(good + "[[body]]\nshapes = \"box\"\n"), HasSubstr("did you mean 'shape'"));
  EXPECT_THAT(message(good + "[[body]]\nmaterial = {younk = 1}\n"),
              HasSubstr("body.material.younk: unknown key; did you mean 'young'"));
  EXPECT_THAT(message(with("shape = \"box\"", "shape = \"box\"\nradius = 1")),
              AllOf(HasSubstr("p.toml:12: body 1.radius: has no meaning with the other keys here"),
                    HasSubstr("lower")));
}

// No message has a place that is none, or an empty key.
TEST_F(MpmFiles, MessagesNameNoEmptyPlace) {
  for (const std::string& text :
       {std::string(), std::string("\n[grid]"), with("velocity = [0.1", "velocity = [1e400"),
        with("\"cpls\"", "\"q9\"\norder = 0"), with("cells = 10", "cells = 5"),
        with("\"cpls\"", "\"q8\"").replace(good.find("cells = 10"), 10, "cells = 5 "),
        with("[time]", "[timer]"), with("[[body]]", "[[bodies]]"), with("end = 0.5", "")}) {
    const std::string what = message(text);
    EXPECT_THAT(what, Not(HasSubstr(": :"))) << text;
    EXPECT_THAT(what, Not(HasSubstr(":1: "))) << text;
  }
  EXPECT_THAT(message(good, {"method.name=cpsl"}), HasSubstr("p.toml: method.name: unknown"));
}

// A choice beside the name is part of what the method is called; one that is in the name as well is
// refused.
TEST_F(MpmFiles, AChoiceIsSaidOnce) {
  const std::string beside = with("\"cpls\"", "\"cpdi1\"\nblend = 0.25");
  const auto name_of = [&](const std::vector<std::string>& settings) {
    return std::get<ProblemFile<2>>(read_problem_text(beside, "p.toml", settings))
        .problem.method.name;
  };
  EXPECT_EQ(name_of({}), "cpdi1+blend=0.25");
  EXPECT_EQ(name_of({"method.name=cpdi1+affine"}), "cpdi1+affine+blend=0.25");
  EXPECT_EQ(name_of({"method.blend=0"}), "cpdi1");
  EXPECT_THAT(
      message(beside, {"method.name=cpdi1+blend=0.5"}),
      HasSubstr("blend of the method = 0.5: stands in the name 'cpdi1+blend=0.5' and beside it"));
  EXPECT_THAT(message(with("\"cpls\"", "\"cpdi1+affine\"\nvelocity = \"mass_weighted\"")),
              HasSubstr("method.velocity: velocity of the method = affine: stands in the name"));
  EXPECT_THAT(message(with("\"cpls\"", "\"cpdi1+flip+pic\"")), HasSubstr("is said before in"));
}

// Texts that toml++ assumes not to exist.
TEST_F(MpmFiles, BrokenTomlIsAnError) {
  EXPECT_THAT(message("[[[a]]b]"), HasSubstr("p.toml:1: "));
  EXPECT_THAT(message(good + "\n\n[[[a]]b]\n[c]\n"), HasSubstr("p.toml:25: "));
  EXPECT_THAT(message("a = \"\"\"\n\n\"\"\"\n[[ [a"), HasSubstr("p.toml:4: "));
  EXPECT_THAT(message(good, {"cells=1\nyoung=2"}), HasSubstr("is no value"));
  // Beyond ASCII: in texts and comments only (toml++ has undefined behaviour for U+00A1 elsewhere).
  const std::string beyond = "beyond ASCII outside of a text";
  EXPECT_THAT(message("# \u00b5\na = \"\u00b5 \\\" \" \u00a1\n"),
              AllOf(HasSubstr("p.toml:2: "), HasSubstr(beyond)));
  EXPECT_THAT(message("a = \'\'\'\n\u00b5 \\\'\'\'\n\u00a1 = 1\n"),
              AllOf(HasSubstr("p.toml:3: "), HasSubstr(beyond)));
  EXPECT_THAT(message("a = 1\n[\u00a1]\n"), HasSubstr("p.toml:2: "));
  EXPECT_THAT(
      message(
          "# \u00b5\n\"\u00b5\" = \'\u00b5\' # \u00b5\n[grid]\nx = \"\"\"\u00b5\n\"\u00b5\"\"\"\n"),
      Not(HasSubstr(beyond)));
  EXPECT_THAT(message(good, {"cells=[[[a]]b]"}), HasSubstr("grid.cells: a number is needed"));
}

TEST_F(MpmFiles, FieldsAreChosen) {
  const auto fields = [&](const std::string& output) {
    EXPECT_EQ(message(good + output), "") << output;
    return std::get<ProblemFile<2>>(read_problem(folder_ / "p.toml")).output.fields;
  };
  EXPECT_EQ(fields(""), default_particle_fields());
  EXPECT_EQ(fields("[output]\nfields = [\"energy\", \"F\"]\n"),
            (std::vector<std::string>{"energy", "F"}));
  EXPECT_TRUE(fields("[output]\nfields = []\n").empty());
  EXPECT_THAT(message(good + "[output]\nfields = [\"presure\"]\n"),
              AllOf(HasSubstr("p.toml:24: output.fields"), HasSubstr("did you mean 'pressure'")));
  EXPECT_THAT(message(good + "[output]\nfields = [\"F\", \"F\"]\n"), HasSubstr("given twice"));
  EXPECT_THAT(message(good + "[output]\nfields = \"F\"\n"), HasSubstr("a list is needed"));
  EXPECT_THAT(message(good + "[output]\nfields = [1]\n"), HasSubstr("a text is needed"));
}

TEST_F(MpmFiles, SettingsReplaceValues) {
  EXPECT_EQ(
      message(good, {"cells=20", "method.name=mpm", "particles=3", "momentum_correction=true"}),
      "");
  const auto file = std::get<ProblemFile<2>>(
      read_problem(folder_ / "p.toml",
                   std::vector<std::string>{"cells=20", "name=impm", "particles=3", "threads=2"}));
  EXPECT_EQ(file.problem.method.name, "impm");
  EXPECT_EQ(file.problem.threads, 2);
  EXPECT_EQ(file.problem.particles.size(), 144u);
  EXPECT_THAT(message(good, {"cels=20"}), HasSubstr("cells"));
  EXPECT_THAT(message(good, {"cells"}), HasSubstr("key=value"));
  EXPECT_THAT(message(good, {"cells=many"}), HasSubstr("a number is needed"));
}

TEST_F(MpmFiles, BodiesOfAllShapes) {
  const auto count = [&](const std::string& body) {
    const std::string what =
        message(with("shape = \"box\"\nlower = [0.2, 0.2]\nupper = [0.4, 0.4]", body));
    EXPECT_EQ(what, "") << body;
    const auto file = std::get<ProblemFile<2>>(read_problem(folder_ / "p.toml"));
    double volume = 0;
    for (const double v : file.problem.particles.volume0) volume += v;
    return volume;
  };
  EXPECT_NEAR(count("shape = \"disk\"\ncentre = [0.5, 0.5]\nradius = 0.4\nparticles = 8"),
              M_PI * 0.16, 0.002);
  EXPECT_NEAR(
      count("shape = \"ring\"\nlayout = \"polar\"\ncentre = [0.5, 0.5]\ninner = 0.2\nouter = 0.4"),
      M_PI * 0.12, 1e-12);
  EXPECT_NEAR(count("shape = \"polygon\"\nwkt = \"POLYGON((0 0, 1 0, 0 1, 0 0))\"\nparticles = 8"),
              0.5, 0.01);
  EXPECT_NEAR(
      count("shape = \"box\"\nlower = [0.2, 0.2]\nupper = [0.4, 0.4]\nlayout = \"jittered\""), 0.04,
      1e-12);
  std::ofstream(folder_ / "grains.csv") << "x,y,volume\n0.5,0.5,0.01\n0.6,0.5,0.02\n";
  EXPECT_NEAR(count("shape = \"file\"\nfile = \"grains.csv\""), 0.03, 1e-12);
  EXPECT_THAT(message(with("shape = \"box\"\nlower = [0.2, 0.2]\nupper = [0.4, 0.4]",
                           "shape = \"polygon\"\nwkt = \"POLYGON((0 0, 1 0\"")),
              HasSubstr("wkt"));
  EXPECT_THAT(message(with("shape = \"box\"\nlower = [0.2, 0.2]\nupper = [0.4, 0.4]",
                           "shape = \"polygon\"\nwkt = \"POLYGON((0 0, 1 1, 1 0, 0 1, 0 0))\"")),
              HasSubstr("wkt"));
}

// A constant body force is gravity, and one of time is integrated in time.
TEST_F(MpmFiles, BodyForceByExpression) {
  const auto momentum = [&](const std::string& loads) {
    EXPECT_EQ(message(good + loads), "");
    auto file = std::get<ProblemFile<2>>(read_problem(folder_ / "p.toml"));
    for (auto& v : file.problem.particles.v) v.setZero();
    for (auto& L : file.problem.particles.L) L.setZero();
    Simulation<2> simulation(file.problem);
    for (int s = 0; s < 10; ++s) simulation.step(0.01);
    Vector<2> sum = Vector<2>::Zero();
    for (std::size_t p = 0; p < simulation.particles().size(); ++p)
      sum += simulation.particles().mass[p] * simulation.particles().v[p];
    return sum;
  };
  const double mass = 40;  // velocities are those of t = 0.095
  const Vector<2> gravity = momentum("[loads]\ngravity = [0.5, -1.0]\n");
  const Vector<2> force = momentum("[loads]\nbody_force = [\"1 / 2\", -1]\n");
  EXPECT_LE((gravity - mass * 0.095 * Vector<2>(0.5, -1)).norm(), 1e-12 * mass);
  EXPECT_LE((force - gravity).norm(), 1e-12 * mass);
  const Vector<2> growing = momentum("[constants]\na = 3\n[loads]\nbody_force = [\"a * t\", 0]\n");
  double expected = 0;  // kicks: half a step at t = 0, then whole ones at 0.01, ..., 0.09
  for (int s = 1; s < 10; ++s) expected += 0.01 * 3 * 0.01 * s;
  EXPECT_NEAR(growing[0], mass * expected, 1e-12 * mass);
}

// One number, that assigns nothing.
TEST_F(MpmFiles, FormulasAreOneNumber) {
  EXPECT_THAT(message(with("\"0.1 * X\"", "\"1,5\"")),
              AllOf(HasSubstr("p.toml:14: body 1.velocity"), HasSubstr("a list of 2")));
  EXPECT_THAT(message(with("\"0.1 * X\"", "\"X = 5\"")), HasSubstr("assigns nothing"));
  EXPECT_THAT(message(with("\"0.1 * X\"", "\"X += 5\"")), HasSubstr("assigns nothing"));
  EXPECT_THAT(message(with("\"0.1 * X\"", "\"\"")), HasSubstr("empty"));
  EXPECT_EQ(message(with("\"0.1 * X\"", "\"max(1, 5) * (X >= 0.3) + (X == 2)\"")), "");
}

TEST_F(MpmFiles, ConstantsMayBeFormulasOfOthers) {
  const auto velocity = [](const std::string& constants) {
    const auto file = std::get<ProblemFile<2>>(
        read_problem_text(with("\"0.1 * X\"", "\"A\"") + constants, "p.toml"));
    return file.problem.particles.v[0][1];
  };
  EXPECT_EQ(velocity("[constants]\nB = 2\nA = \"3 * B + pi - pi\"\n"), 6);
  EXPECT_EQ(velocity("[constants]\nA = \"2 * Z1\"\nZ1 = \"B\"\nB = 4\n"), 8);
  const auto wrong = [&](const std::string& constants) {
    return message(good + "[constants]\n" + constants);
  };
  EXPECT_THAT(wrong("A = \"B\"\nB = \"A\"\n"), HasSubstr("constants.A: 'B'"));
  EXPECT_THAT(wrong("A = \"2 * X\"\n"), HasSubstr("constants.A: '2 * X'"));
  EXPECT_THAT(wrong("A = \"1 / 0\"\n"), HasSubstr("not finite"));
  EXPECT_THAT(wrong("A = true\n"), HasSubstr("a number is needed"));
  EXPECT_THAT(wrong("A = \"1, 2\"\n"), HasSubstr("a list of 2"));
  EXPECT_THAT(wrong("X = 3\n"), HasSubstr("constants.X: 'X' has a meaning"));
  EXPECT_THAT(wrong("pi = 3\n"), HasSubstr("'pi' has a meaning"));
  EXPECT_THAT(wrong("a-b = 3\n"), HasSubstr("constants.a-b"));
}

// Copies of one problem with formulas, one after the other and all at once: the same bits.
TEST_F(MpmFiles, CopiesOfAProblemRunSideBySide) {
  const std::string text =
      good + "[loads]\nbody_force = [\"0.2 * sin(6 * X) * cos(3 * Y)\", \"0.2 * X * y + t\"]\n";
  const Problem<2> problem = std::get<ProblemFile<2>>(read_problem_text(text, "p.toml")).problem;
  const auto go = [](Problem<2> copy) {
    Simulation<2> simulation(std::move(copy));
    for (int s = 0; s < 40; ++s) simulation.step(0.002);
    return simulation.particles().x;
  };
  const auto alone = go(problem);
  std::vector<std::vector<Vector<2>>> results(4);
  std::vector<std::thread> threads;
  for (auto& result : results) threads.emplace_back([&] { result = go(problem); });
  for (auto& thread : threads) thread.join();
  for (const auto& result : results)
    EXPECT_EQ(0, std::memcmp(result.data(), alone.data(), alone.size() * sizeof(Vector<2>)));
}

// No body is cut by the border of the grid, whatever its shape.
TEST_F(MpmFiles, BodiesLieInTheGrid) {
  const auto of = [&](const std::string& body) {
    return message(with("shape = \"box\"\nlower = [0.2, 0.2]\nupper = [0.4, 0.4]", body));
  };
  EXPECT_THAT(of("shape = \"box\"\nlower = [0.9, 0.4]\nupper = [1.1, 0.6]"),
              AllOf(HasSubstr("p.toml:11: body 1.shape"), HasSubstr("(0.9, 0.4) to (1.1, 0.6)"),
                    HasSubstr("the grid"), HasSubstr("no body is cut")));
  EXPECT_THAT(of("shape = \"disk\"\ncentre = [0.1, 0.5]\nradius = 0.2"),
              HasSubstr("no body is cut"));
  EXPECT_THAT(of("shape = \"ring\"\ncentre = [0.1, 0.5]\ninner = 0.1\nouter = 0.2\nlayout = "
                 "\"polar\""),
              HasSubstr("no body is cut"));
  EXPECT_THAT(of("shape = \"polygon\"\nwkt = \"POLYGON((0.2 0.2, 0.5 0.2, 0.2 1.5))\""),
              HasSubstr("no body is cut"));
  std::ofstream(folder_ / "points.csv") << "x,y\n0.5,0.5\n1.01,0.5\n";
  EXPECT_THAT(of("shape = \"file\"\nfile = \"points.csv\"\nvolume = 0.01"),
              AllOf(HasSubstr("body 1.file"), HasSubstr("must lie in the grid")));
  // On the border, up to rounding, is in the grid.
  EXPECT_EQ(of("shape = \"disk\"\ncentre = [0.2, 0.2]\nradius = 0.2"), "");
  EXPECT_EQ(of("shape = \"box\"\nlower = [0, 0]\nupper = [1.00000000001, 1]"), "");
}

TEST_F(MpmFiles, WhatAFileSaysIsCheckedByTheProblem) {
  EXPECT_THAT(message(with("poisson = 0.3", "poisson = 0.5")), HasSubstr("material.poisson"));
  EXPECT_THAT(message(with("density = 1000", "density = -1")),
              HasSubstr("p.toml:9: material.density: density = -1: must be positive"));
  EXPECT_THAT(message(with("at = 0", "at = 0.123")),
              HasSubstr("p.toml:17: boundary 1.at: at of a boundary with images"));
  EXPECT_THAT(message(good + "courant = 0\n"), HasSubstr("time.courant: courant = 0: must be"));
  EXPECT_THAT(message(good + "rule = \"fixed\"\nstep = -1\n"), HasSubstr("time.step: step = -1"));
  EXPECT_THAT(message(good + "[limits]\nsteps = 0\n"), HasSubstr("limits."));
  EXPECT_THAT(message(good + "[limits]\nmemory = nan\n"), HasSubstr("limits.memory"));
}

// A run says what it expects, and is refused where that is too much.
TEST_F(MpmFiles, TooMuchIsRefusedWithNumbers) {
  const auto refusal = [&](const std::string& more, std::vector<std::string> settings = {}) {
    try {
      const AnyProblem any = read_problem_text(good + more, "p.toml", settings);
      run(std::get<ProblemFile<2>>(any), {.folder = folder_ / "out"});
    } catch (const InvalidArgument& error) {
      return std::string(error.what());
    } catch (const FileError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(refusal("rule = \"fixed\"\nstep = 1e-300\n"),
              AllOf(HasSubstr("steps = 5e+299"), HasSubstr("1e+09")));
  EXPECT_THAT(refusal("rule = \"fixed\"\nstep = 1e-6\n", {"limits.steps=1000"}),
              AllOf(HasSubstr("steps = 5e+05"), HasSubstr("limit of 1e+03")));
  EXPECT_THAT(refusal("", {"limits.memory=10000"}), HasSubstr("memory = "));
  EXPECT_THAT(refusal("", {"limits.memory=100"}), HasSubstr("particles of a body = "));
  EXPECT_THAT(refusal("", {"grid.cells=30000", "body.particles=100"}),
              HasSubstr("more than there is memory for"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out"));
  EXPECT_EQ(refusal("", {"end=0.01"}), "");
  auto by_hand = std::get<ProblemFile<2>>(read_problem_text(good, "p.toml"));
  by_hand.limits.steps = 0;
  EXPECT_THROW(run(by_hand, {.folder = folder_ / "none"}), InvalidArgument);
  by_hand.limits = {.memory = NAN};
  EXPECT_THROW(run(by_hand, {.folder = folder_ / "none"}), InvalidArgument);
}

TEST_F(MpmFiles, AForecastIsTrue) {
  EXPECT_EQ(message(good), "");
  auto file = std::get<ProblemFile<2>>(read_problem(folder_ / "p.toml"));
  file.problem.time.end = 0.02;
  Forecast told;
  const RunResult result =
      run(file, {.folder = folder_ / "out", .begins = [&](const Forecast& f) { told = f; }});
  EXPECT_EQ(told.particles, 16u);
  EXPECT_EQ(told.nodes, 121u);
  EXPECT_NEAR(told.steps, static_cast<double>(result.steps), 1);
  EXPECT_NEAR(told.step.dt, result.longest_step, 0.5 * told.step.dt);
  EXPECT_GT(told.memory, 16 * 200);
  EXPECT_TRUE(told.warnings.empty());
  file.problem.time.courant = 1.5;  // longer than cpls bears
  ASSERT_EQ(forecast(file.problem).warnings.size(), 1u);
  EXPECT_THAT(forecast(file.problem).warnings[0], HasSubstr("cpls"));
  file.problem.time.courant = 0.4;
  file.problem.damping.mass = 0.9 / told.step.dt;
  EXPECT_TRUE(forecast(file.problem).warnings.empty());
  file.problem.damping.mass = 1.1 / told.step.dt;
  ASSERT_EQ(forecast(file.problem).warnings.size(), 1u);
  EXPECT_THAT(forecast(file.problem).warnings[0], HasSubstr("damping.mass times the first step"));
}

// Images count in it: they are copies of particles, and fits see them once more.
TEST_F(MpmFiles, AForecastKnowsOfImages) {
  for (const char* method : {"cpdi1", "cpls"}) {
    ASSERT_EQ(message(with("\"cpls\"", "\"" + std::string(method) + "\"")), "");
    auto file = std::get<ProblemFile<2>>(read_problem(folder_ / "p.toml"));
    Problem<2>& problem = file.problem;
    problem.grid = Grid<2>({-0.5, 0}, {1, 1}, 0.1);
    problem.boundaries.clear();
    const double none = forecast(problem).memory;
    Boundary<2> mirror;
    mirror.images = true;
    mirror.velocity[0] = 0.0;
    problem.boundaries = {mirror};
    std::size_t images = 0;  // of particles within four cells
    for (const Vector<2>& x : problem.particles.x) images += x[0] <= 4 * 0.1 ? 1 : 0;
    ASSERT_GT(images, 3u);
    const double each = (forecast(problem).memory - none) / static_cast<double>(images);
    const double particle = bytes_of_particle<2>(problem.kept());
    EXPECT_GE(each, particle + sizeof(Image<2>)) << method;
    EXPECT_LE(each, 4 * particle) << method;
  }
}

// What docs/mpm.md has measured of energy between walls with images.
TEST_F(MpmFiles, AForecastWarnsOfWallsBetweenNodes) {
  for (const auto& [method, warned] :
       std::vector<std::pair<const char*, bool>>{{"mpm", true},
                                                 {"fmpm", true},
                                                 {"ugimp", false},
                                                 {"cpdi1", false},
                                                 {"bspline2", false}}) {
    ASSERT_EQ(message(with("\"cpls\"", "\"" + std::string(method) + "\"")), "");
    auto file = std::get<ProblemFile<2>>(read_problem(folder_ / "p.toml"));
    Problem<2>& problem = file.problem;
    problem.boundaries.resize(1);
    problem.boundaries[0] = {};
    problem.boundaries[0].images = true;
    problem.boundaries[0].velocity[0] = 0.0;
    for (const double lower : {-0.5, -0.53}) {
      problem.grid = Grid<2>({lower, 0}, {lower + 1.5, 1}, 0.1);
      const auto warnings = forecast(problem).warnings;
      const bool found = std::any_of(warnings.begin(), warnings.end(), [](const std::string& each) {
        return each.find("the wall at x = 0 lies between nodes") != std::string::npos;
      });
      EXPECT_EQ(found, warned && lower == -0.53) << method;
    }
  }
}

// The step from the largest stable one of the method in use.
TEST_F(MpmFiles, AStepFromTheMeasuredLimit) {
  for (const char* method : {"cpls", "bspline2", "fmpm", "cpdi1+mass=consistent"}) {
    const std::string text = with("\"cpls\"", "\"" + std::string(method) + "\"");
    ASSERT_EQ(message(text + "courant = \"auto\"\n"), "") << method;
    const auto file = std::get<ProblemFile<2>>(read_problem(folder_ / "p.toml"));
    EXPECT_DOUBLE_EQ(*file.problem.time.courant, 0.8 * stable_courant(file.problem.method, 2));
    EXPECT_TRUE(forecast(file.problem).warnings.empty()) << method;
  }
  EXPECT_THAT(message(good + "courant = \"much\"\n"),
              HasSubstr("time.courant: a number or \"auto\" is needed"));
  EXPECT_THAT(message(good + "courant = \"auto\"\nrule = \"bar_wave\"\n"),
              HasSubstr("needs the rule adaptive or p_wave"));
  EXPECT_THAT(message(with("\"cpls\"", "\"q8\"") + "courant = \"auto\"\n"),
              HasSubstr("no step is stable with the method q8"));
}

// Walls between the nodes have images, those on nodes only where that is asked for; a period gets
// its cells beyond both ends.
TEST_F(MpmFiles, ImagesAndPeriods) {
  const auto problem_of = [&](const std::string& text) {
    EXPECT_EQ(message(text), "");
    return std::get<ProblemFile<2>>(read_problem(folder_ / "p.toml")).problem;
  };
  const std::string wide = with("lower = [0.0, 0.0]", "lower = [-0.5, 0.0]");
  const auto at = [&](const std::string& place) {
    std::string text = wide;
    return text.replace(text.find("at = 0\n"), 6, place);
  };
  EXPECT_FALSE(problem_of(at("at = 0")).boundaries[0].images);
  EXPECT_TRUE(problem_of(at("at = 0\nimages = true")).boundaries[0].images);
  EXPECT_TRUE(problem_of(at("at = 0.13")).boundaries[0].images);
  EXPECT_THAT(message(at("at = 0.13\nimages = false")), HasSubstr("must be a plane of nodes"));
  EXPECT_THAT(message(at("at = 0.5")), Not(HasSubstr("images")));
  EXPECT_THAT(message(at("at = 0.13\nimages = 3")), HasSubstr("boundary 1.images"));

  const std::string free = with("[[boundary]]\naxis = \"x\"\nat = 0\nkind = \"fixed\"\n", "");
  const auto periodic = [&](const std::string& which) {
    std::string text = free;
    return text.replace(text.find("cells = 10"), 10, "cells = 10\nperiodic = " + which);
  };
  const Problem<2> period = problem_of(periodic("[true, false]"));
  EXPECT_EQ(period.grid.cells(0), 10 + 2 * image_cells);
  EXPECT_EQ(period.grid.cells(1), 10);
  EXPECT_NEAR(period.room(0).first, 0, 1e-14);
  EXPECT_NEAR(period.room(0).second, 1, 1e-14);
  EXPECT_THAT(message(periodic("[true]")), HasSubstr("grid.periodic: 2 values are needed"));
  EXPECT_THAT(message(periodic("[1, 0]")), HasSubstr("true or false is needed for each axis"));

  // A box from its own corner on.
  std::string text = free;
  text.replace(text.find("lower = [0.2, 0.2]\nupper = [0.4, 0.4]"), 37,
               "lower = [0.21, 0.2]\nupper = [0.41, 0.4]\nlayout = \"body\"");
  const Problem<2> own = problem_of(text);
  ASSERT_EQ(own.particles.size(), 16u);
  EXPECT_NEAR(own.particles.X[0][0], 0.235, 1e-12);
  EXPECT_NEAR(own.particles.X[15][0], 0.385, 1e-12);
  text.replace(text.find("0.41, 0.4"), 9, "0.42, 0.4");
  EXPECT_THAT(message(text), HasSubstr("must be a whole number of cells"));
}

TEST_F(MpmFiles, BoundaryVelocities) {
  EXPECT_EQ(message(with("kind = \"fixed\"", "kind = \"velocity\"\nvelocity = [0.5, \"free\"]")),
            "");
  const auto file = std::get<ProblemFile<2>>(read_problem(folder_ / "p.toml"));
  const Boundary<2>& boundary = file.problem.boundaries.front();
  EXPECT_EQ(boundary.velocity[0], 0.5);
  EXPECT_FALSE(boundary.velocity[1].has_value());
  EXPECT_THAT(message(with("kind = \"fixed\"", "kind = \"velocity\"\nvelocity = [0.5, \"fre\"]")),
              HasSubstr("a number, a formula or \"free\""));
}

// A pressure on a side acts on the area of that side.
TEST_F(MpmFiles, PressureAddsUpToForce) {
  EXPECT_EQ(message(good + "[[pressure]]\nside = \"x_upper\"\nmagnitude = 3\n"), "");
  auto file = std::get<ProblemFile<2>>(read_problem(folder_ / "p.toml"));
  Vector<2> area = Vector<2>::Zero();
  for (const auto& load : file.problem.loads) area += load.area;
  EXPECT_LE((area - Vector<2>(0.2, 0)).norm(), 1e-14);
  for (auto& v : file.problem.particles.v) v.setZero();
  Simulation<2> simulation(file.problem);
  simulation.map();
  Vector<2> force = Vector<2>::Zero();
  for (const auto& f : simulation.nodes().force) force += f;
  EXPECT_LE((force - Vector<2>(-0.6, 0)).norm(), 1e-13);
}

// A run in two parts is bit for bit the run in one, ledger included. With elements the disks are
// slow and without stress: they would break.
TEST_F(MpmFiles, RestartIsExact) {
  std::vector<Method> all(methods().begin(), methods().end());
  for (const char* name : {"cpdi2+affine+blend=0.1", "mpm+musl+symplectic_euler"})
    all.push_back(composed(name));
  for (const Method& method : all) {
    auto file = read_example<2>("disks.toml", {"name=" + method.name, "cells=10", "frames=4"});
    if (method.stress == StressUpdate::musl) {  // with a history, too
      VonMises soft{lame(file.problem.materials[0])};
      soft.yield = soft.mu / 100;
      file.problem.materials[1] = soft;
    }
    if (is_element(method.basis)) {
      file.problem.materials.assign(2, NeoHookean{Lame::from(1e-9, 0.3)});
      file.problem.time.courant = 0.05;
    } else {
      for (auto& v : file.problem.particles.v) v *= 8;
    }
    file.problem.time.end = 0.6;
    const auto whole = folder_ / (method.name + "_whole"),
               parts = folder_ / (method.name + "_parts");
    run(file, {.folder = whole, .name = "d"});

    struct Stop {};
    std::int64_t steps = 0;
    try {
      run(file, {.folder = parts,
                 .name = "d",
                 .progress = [&](double time, std::int64_t at, const TimeStep&) {
                   steps = at;
                   if (time > 0.4) throw Stop{};
                 }});
      FAIL();
    } catch (const Stop&) {
    }
    EXPECT_GT(steps, 3);
    run(file, {.folder = parts, .name = "d", .restart = parts / "checkpoint.h5"});
    EXPECT_EQ(contents(whole / "ledger.csv"), contents(parts / "ledger.csv")) << method.name;
    EXPECT_EQ(contents(whole / "d_particles_0004.vtp"), contents(parts / "d_particles_0004.vtp"));
    EXPECT_EQ(contents(whole / "d_nodes_0004.vti"), contents(parts / "d_nodes_0004.vti"));
    EXPECT_EQ(contents(whole / "d_particles.pvd"), contents(parts / "d_particles.pvd"));
    Simulation<2> a(file.problem), b(file.problem);
    read_checkpoint(whole / "checkpoint.h5", a, file.formulas);
    read_checkpoint(parts / "checkpoint.h5", b, file.formulas);
    EXPECT_EQ(0, std::memcmp(a.particles().x.data(), b.particles().x.data(),
                             a.particles().size() * sizeof(Vector<2>)));
    EXPECT_EQ(a.time(), b.time());
  }
}

// Choices in the name, beside the name, and by settings are the same.
TEST_F(MpmFiles, MethodsAreComposed) {
  const auto method = [&](const std::string& lines, const std::vector<std::string>& settings = {}) {
    EXPECT_EQ(message(with("name = \"cpls\"", lines), settings), "");
    return std::get<ProblemFile<2>>(read_problem(folder_ / "p.toml", settings)).problem.method;
  };
  const Method named = method("name = \"cpdi1+affine+update=flip+blend=0.25+musl+degree=2\"");
  const Method beside = method(
      "name = \"cpdi1\"\nvelocity = \"affine\"\nupdate = \"flip\"\nblend = 0.25\nstress = "
      "\"musl\"\ndegree = 2");
  const Method set = method("name = \"mpm\"", {"domain=cpdi1", "method.velocity=affine",
                                               "blend=0.25", "stress=musl", "degree=2"});
  for (const std::string& key : method_keys()) {
    EXPECT_EQ(choice_text(named, key), choice_text(beside, key)) << key;
    EXPECT_EQ(choice_text(named, key), choice_text(set, key)) << key;
  }
  EXPECT_THAT(message(with("\"cpls\"", "\"cpls+velocty=mls\"")),
              AllOf(HasSubstr("method.name"), HasSubstr("velocity")));
  EXPECT_THAT(message(with("\"cpls\"", "\"mpm\"\nblend = 2")), HasSubstr("from 0 to 1"));
  EXPECT_THAT(message(with("\"cpls\"", "\"mpm\"\nblend = \"much\"")),
              HasSubstr("method.blend: a number is needed"));
  EXPECT_THAT(message(with("\"cpls\"", "\"mpm\"\ndomain = \"cpdi\"")),
              AllOf(HasSubstr("method.domain"), HasSubstr("cpdi1")));
}

TEST_F(MpmFiles, MaterialsHaveTheirConstants) {
  const std::string plastic = with("young = 1000", "young = 1000\nkind = \"von_mises\"\nyield = 3");
  EXPECT_THAT(message(plastic), HasSubstr("material.hardening: is missing"));
  EXPECT_EQ(message(plastic, {"hardening=7"}), "");
  const auto file = std::get<ProblemFile<2>>(
      read_problem(folder_ / "p.toml", std::vector<std::string>{"hardening=7"}));
  const auto* material = std::get_if<VonMises>(&file.problem.materials[0]);
  ASSERT_TRUE(material);
  EXPECT_EQ(material->yield, 3);
  EXPECT_EQ(material->hardening, 7);
  EXPECT_THAT(message(plastic, {"hardening=-7"}), HasSubstr("hardening"));
  EXPECT_THAT(message(with("young = 1000", "young = 1000\nyield = 3")),
              HasSubstr("material.yield: has no meaning"));
}

// Without a ledger the summary of a run knows the first and the last state.
TEST_F(MpmFiles, WithoutALedgerTheEndsAreAccountedFor) {
  auto file = read_example<2>("disks.toml", {"cells=10", "frames=0", "name=cpls"});
  file.problem.time.end = 0.1;
  const RunResult with_ledger = run(file, {.folder = folder_ / "with"});
  file.output.ledger = false;
  const RunResult without = run(file, {.folder = folder_ / "without"});
  EXPECT_FALSE(std::filesystem::exists(folder_ / "without" / "ledger.csv"));
  EXPECT_EQ(ledger_row(with_ledger.first), ledger_row(without.first));
  Ledger expected = with_ledger.last;
  expected.work = std::nan("");  // which nobody has summed up
  EXPECT_EQ(ledger_row(expected), ledger_row(without.last));
  EXPECT_GT(without.steps, 2);
}

TEST_F(MpmFiles, ResultsOfAnotherRunAreKept) {
  auto file = read_example<2>("disks.toml", {"cells=10", "frames=2"});
  file.problem.time.end = 0.1;
  run(file, {.folder = folder_ / "out"});
  EXPECT_THROW(run(file, {.folder = folder_ / "out"}), FileError);
  EXPECT_NO_THROW(run(file, {.folder = folder_ / "out", .overwrite = true}));
  const auto ledger = read_particles(folder_ / "out" / "ledger.csv");
  EXPECT_TRUE(ledger.has("algorithmic_error"));
}

TEST_F(MpmFiles, WrongCheckpointsAreAnswered) {
  auto file = read_example<2>("disks.toml", {"cells=10", "frames=1", "name=mpm"});
  file.problem.time.end = 0.05;
  run(file, {.folder = folder_ / "out"});
  const auto what = [&](auto simulation, const std::filesystem::path& path) -> std::string {
    try {
      read_checkpoint(path, simulation, file.formulas);
    } catch (const FileError& error) {
      return error.what();
    }
    return "";
  };
  const auto checkpoint = folder_ / "out" / "checkpoint.h5";
  EXPECT_EQ(what(Simulation<2>(file.problem), checkpoint), "");
  auto other = file.problem;
  other.method = method_named("impm");
  EXPECT_THAT(what(Simulation<2>(other), checkpoint),
              HasSubstr("method.velocity is mass_weighted in the checkpoint, mls now"));
  EXPECT_THAT(what(Simulation<2>(file.problem), folder_ / "none.h5"), HasSubstr("no such file"));
}

// Where a checkpoint lies says which run it is of.
TEST_F(MpmFiles, ARestartKeepsOtherRuns) {
  auto file = read_example<2>("disks.toml", {"cells=10", "frames=4"});
  file.problem.time.end = 0.1;
  const auto out = folder_ / "out", other = folder_ / "other", checkpoint = out / "checkpoint.h5";
  run(file, {.folder = out});
  run(file, {.folder = other});
  const std::string ledger = contents(other / "ledger.csv");
  file.problem.time.end = 0.15;
  EXPECT_THROW(run(file, {.folder = other, .restart = checkpoint}), OtherRun);
  EXPECT_EQ(contents(other / "ledger.csv"), ledger);
  EXPECT_THAT(contents(out / "run_particles.pvd"), HasSubstr("run_particles_0004"));

  // In a new folder, and in one that may be overwritten: nothing of what was before.
  for (const bool overwrite : {false, true}) {
    const auto folder = overwrite ? other : folder_ / "new";
    const RunResult result =
        run(file, {.folder = folder, .restart = checkpoint, .overwrite = overwrite});
    EXPECT_GT(result.frames, 5u);
    EXPECT_NEAR(read_particles(folder / "ledger.csv").column("time")[0], 0.1, 1e-12);
    EXPECT_THAT(contents(folder / "run_particles.pvd"),
                AllOf(HasSubstr("run_particles_0005"), Not(HasSubstr("run_particles_0004"))));
  }
  // A copy beside the checkpoint is of the same run.
  std::filesystem::copy(checkpoint, out / "saved.h5");
  run(file, {.folder = out, .restart = out / "saved.h5"});
  EXPECT_EQ(read_particles(out / "ledger.csv").column("time")[0], 0);
  EXPECT_THAT(contents(out / "run_particles.pvd"),
              AllOf(HasSubstr("run_particles_0004"), HasSubstr("run_particles_0005")));
  file.problem.time.end = 0.12;
  try {
    run(file, {.folder = out, .restart = checkpoint});
    ADD_FAILURE();
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), HasSubstr("after the end of the problem"));
  }
}

// A disk that fills may cut the last row anywhere.
TEST_F(MpmFiles, ACutRowOfTheLedgerIsDropped) {
  auto file = read_example<2>("disks.toml", {"cells=10", "frames=2"});
  file.problem.time.end = 0.2;
  run(file, {.folder = folder_ / "out"});
  const std::string whole = contents(folder_ / "out" / "ledger.csv");
  std::ofstream(folder_ / "out" / "ledger.csv", std::ios::app) << "1";
  run(file, {.folder = folder_ / "out", .restart = folder_ / "out" / "checkpoint.h5"});
  EXPECT_EQ(contents(folder_ / "out" / "ledger.csv"), whole);
}

// A run that is stopped and gone on with is the run in one, bit for bit.
TEST_F(MpmFiles, ARunCanBeStopped) {
  auto file = read_example<2>("disks.toml", {"cells=10", "frames=4"});
  file.problem.time.end = 0.5;
  const RunResult whole = run(file, {.folder = folder_ / "whole"});
  EXPECT_FALSE(whole.stopped);
  int asked = 0;
  std::int64_t saved = -1;
  RunOptions options{.folder = folder_ / "parts"};
  options.saved = [&](double, std::int64_t steps) { saved = steps; };
  options.stop = [&] { return ++asked == 4; };
  const RunResult part = run(file, options);
  EXPECT_TRUE(part.stopped);
  EXPECT_EQ(part.steps, 3);
  EXPECT_EQ(saved, 3);
  EXPECT_LT(part.time, whole.time);
  options.restart = options.folder / "checkpoint.h5";
  EXPECT_FALSE(run(file, options).stopped);
  for (const char* name : {"ledger.csv", "checkpoint.h5", "run_particles_0004.vtp",
                           "run_nodes_0004.vti", "run_particles.pvd"})
    EXPECT_TRUE(contents(folder_ / "whole" / name) == contents(folder_ / "parts" / name)) << name;
}

// The numbers of a field in a VTK XML file.
std::vector<double> numbers_of(const std::string& vtk, const std::string& name, int components) {
  const std::size_t at =
      vtk.find("Name=\"" + name + "\" NumberOfComponents=\"" + std::to_string(components) + "\"");
  if (at == std::string::npos) return {};
  // Base64 of the length in bytes, and of the numbers.
  std::string data;
  std::uint32_t bits = 0;
  int letters = 0;
  for (std::size_t i = vtk.find(">\n", at) + 2; vtk[i] != '\n' && vtk[i] != '='; ++i) {
    constexpr std::string_view alphabet =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    bits = bits << 6 | static_cast<std::uint32_t>(alphabet.find(vtk[i]));
    if (letters++ % 4 != 0) data += static_cast<char>(bits >> (6 - 2 * ((letters - 1) % 4)) & 0xff);
  }
  std::uint64_t bytes = 0;
  std::memcpy(&bytes, data.data(), sizeof bytes);
  std::vector<double> values(bytes / sizeof(double));
  std::memcpy(values.data(), data.data() + sizeof bytes, bytes);
  return values;
}

template <class T>
class MpmFrames : public MpmFiles {};
TYPED_TEST_SUITE(MpmFrames, AllDimensions);

// A step of length 1.
template <int D>
void update(const Material& material, const Matrix<D>& F, const Matrix<D>& L, Matrix<D>& stress,
            double* history) {
  double energy = 0;
  std::visit(
      [&]<class M>(const M& m) {
        if constexpr (history_of<M>() > 0)
          m.update(F, L, 1, stress, energy, history);
        else
          m.update(F, L, 1, stress, energy);
      },
      material);
}

// Vectors and tensors of three dimensions, whose stress is that of the same strain in 3-D.
TYPED_TEST(MpmFrames, AreOfThreeDimensions) {
  constexpr int D = TypeParam::value;
  for (const Material& material :
       {Material(NeoHookean{Lame::from(1000, 0.3)}), Material(LinearElastic{Lame::from(1000, 0.3)}),
        Material(VonMises{Lame::from(1000, 0.3), 50, 10})}) {
    Problem<D> problem = block<D>(4, 0.25, 0.75);
    problem.materials = {material};
    problem.particles.history.resize(history_of(material) * problem.particles.size());
    std::mt19937 random(3);
    for (std::size_t p = 0; p < problem.particles.size(); ++p) {
      problem.particles.F[p] = random_deformation<D>(random, 0.2);
      problem.particles.L[p] = (problem.particles.F[p] - Matrix<D>::Identity());
      update<D>(material, problem.particles.F[p], problem.particles.L[p],
                problem.particles.stress[p],
                problem.particles.history.data() + history_of(material) * p);
      problem.particles.v[p].setConstant(0.25);
    }
    Simulation<D> simulation(problem);
    simulation.map();
    std::vector<double> times;
    FrameOptions options;
    const auto names = particle_fields();
    options.fields.assign(names.begin(), names.end());
    write_frame(this->folder_, "a&b<\"c", simulation, times, options);
    const std::string vtk = this->contents(this->folder_ / "a&b<\"c_particles_0000.vtp");
    const auto stress = numbers_of(vtk, "stress", 9), F = numbers_of(vtk, "F", 9),
               velocity = numbers_of(vtk, "velocity", 3), pressure = numbers_of(vtk, "pressure", 1),
               von_mises = numbers_of(vtk, "von_mises", 1), mass = numbers_of(vtk, "mass", 1),
               volume = numbers_of(vtk, "volume", 1), density = numbers_of(vtk, "density", 1),
               plastic = numbers_of(vtk, "plastic_strain", 1);
    ASSERT_EQ(plastic.size(), problem.particles.size());
    const std::size_t count = problem.particles.size();
    ASSERT_EQ(stress.size(), 9 * count);
    ASSERT_EQ(F.size(), 9 * count);
    ASSERT_EQ(velocity.size(), 3 * count);
    for (std::size_t p = 0; p < count; ++p) {
      Matrix<3> full = Matrix<3>::Identity(), rate = Matrix<3>::Zero(), s = Matrix<3>::Zero();
      full.topLeftCorner<D, D>() = problem.particles.F[p];
      rate.topLeftCorner<D, D>() = problem.particles.L[p];
      double history[2] = {0, 0};
      update<3>(material, full, rate, s, history);
      for (int c = 0; c < 9; ++c) {
        EXPECT_NEAR(stress[9 * p + c], s(c / 3, c % 3), 1e-10) << c;
        EXPECT_EQ(F[9 * p + c], full(c / 3, c % 3));
      }
      for (int d = 0; d < 3; ++d) EXPECT_EQ(velocity[3 * p + d], d < D ? 0.25 : 0);
      EXPECT_NEAR(pressure[p], -s.trace() / 3, 1e-10);
      const double shear = s(0, 1) * s(0, 1) + s(1, 2) * s(1, 2) + s(0, 2) * s(0, 2);
      EXPECT_NEAR(von_mises[p],
                  std::sqrt((std::pow(s(0, 0) - s(1, 1), 2) + std::pow(s(1, 1) - s(2, 2), 2) +
                             std::pow(s(2, 2) - s(0, 0), 2) + 6 * shear) /
                            2),
                  1e-9);
      EXPECT_NEAR(density[p] * volume[p], mass[p], 1e-12 * mass[p]);
      if (history_of(material) == 0) {
        EXPECT_TRUE(std::isnan(plastic[p]));
      } else {
        EXPECT_EQ(plastic[p], problem.particles.history[2 * p]);
      }
    }
    // The list is XML whatever the name.
    EXPECT_THAT(this->contents(this->folder_ / "a&b<\"c_particles.pvd"),
                HasSubstr("file=\"a&amp;b&lt;&quot;c_particles_0000.vtp\""));
    options.fields = {"presure"};
    EXPECT_THROW(write_frame(this->folder_, "x", simulation, times, options), InvalidArgument);
  }
}

// A run that fails leaves the ledger up to the step, and a checkpoint that can be read.
TEST_F(MpmFiles, AFailureLosesNothing) {
  auto file = read_example<2>("wall.toml", {"cells=10", "frames=40", "name=mpm"});
  for (auto& v : file.problem.particles.v) v = Vector<2>(1, 0);
  file.problem.boundaries.clear();  // out of the grid
  file.problem.time.end = 2;
  EXPECT_THROW(run(file, {.folder = folder_ / "out"}), Failure);
  const auto ledger = read_particles(folder_ / "out" / "ledger.csv");
  EXPECT_GT(ledger.size(), 3u);
  Simulation<2> simulation(file.problem);
  read_checkpoint(folder_ / "out" / "checkpoint.h5", simulation, file.formulas);
  EXPECT_GT(simulation.steps(), 0);
}

TEST(MpmExamples, AllAreRead) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(example(""))) {
    if (entry.path().extension() != ".toml") continue;
    EXPECT_NO_THROW(read_problem(entry.path())) << entry.path();
    ++count;
  }
  EXPECT_GE(count, 9);
}

}  // namespace
}  // namespace recon::mpm::test
