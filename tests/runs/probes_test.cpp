// Probes: fields at particles and places, forces through sections, reactions; their rows.
#include <gmock/gmock.h>
#include <stdlib.h>

#include <cmath>
#include <fstream>

#include "recon/io/read.hpp"
#include "recon/runs/external.hpp"
#include "recon/runs/run.hpp"
#include "runs/support.hpp"

namespace recon::mpm::test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

// A block whose fields are linear: x = X, v = a + B X, stress S0 + S1 x.
template <int D>
Simulation<D> linear_block(Vector<D>& a, Matrix<D>& B) {
  Problem<D> problem = block<D>(6, 1.0 / 6, 5.0 / 6, "cpdi1");
  std::mt19937 random(3);
  B = random_deformation<D>(random, 0.5);
  for (int d = 0; d < D; ++d) a[d] = uniform(random, -1, 1);
  for (std::size_t p = 0; p < problem.particles.size(); ++p) {
    const Vector<D>& X = problem.particles.X[p];
    problem.particles.v[p] = a + B * X;
    problem.particles.stress[p] = Matrix<D>::Identity() * (2 + 3 * X[0]);
  }
  Simulation<D> simulation(problem);
  simulation.map();
  return simulation;
}

template <class T>
class Probes : public testing::Test {};
TYPED_TEST_SUITE(Probes, AllDimensions);

// Degree 1 at any place in reach: linear fields are exact, also beside the body; no value without
// data.
TYPED_TEST(Probes, PointsReproduceLinearFields) {
  constexpr int D = TypeParam::value;
  Vector<D> a;
  Matrix<D> B;
  const Simulation<D> simulation = linear_block<D>(a, B);
  std::mt19937 random(5);
  for (int round = 0; round < 10; ++round) {
    Vector<D> at;
    for (double& each : at) each = uniform(random, 0.13, 0.87);
    const Probe<D> probe = point_probe<D>(simulation.problem(), at, 0.25, {"velocity", "mass"});
    const std::vector<double> found = probe.measure(simulation);
    ASSERT_EQ(found.size(), probe.columns.size());
    for (int d = 0; d < D; ++d) EXPECT_NEAR(found[d], (a + B * at)[d], 1e-12);
    EXPECT_NEAR(found[D], simulation.particles().mass[0], 1e-12 * found[D]);
  }
  const Probe<D> far = point_probe<D>(simulation.problem(), Vector<D>::Zero(), 0.1, {"velocity"});
  for (const double value : far.measure(simulation)) EXPECT_TRUE(std::isnan(value));
}

// A section through a block of linear stress: force and moment of the linear law, for the tent is
// integrated exactly by particles that lie evenly.
TYPED_TEST(Probes, SectionsHaveResultants) {
  constexpr int D = TypeParam::value;
  Vector<D> a;
  Matrix<D> B;
  const Simulation<D> simulation = linear_block<D>(a, B);
  const double side = 4.0 / 6, area = std::pow(side, D - 1);
  for (const double at : {0.5, 2.0 / 6, 0.5 + 1.0 / 12}) {
    const Probe<D> probe = section_probe<D>(simulation.problem(), 0, at);
    const std::vector<double> found = probe.measure(simulation);
    EXPECT_NEAR(found[0], (2 + 3 * at) * area, 1e-12);
    const std::size_t turns = D == 1 ? 0 : D == 2 ? 1 : 3;
    for (std::size_t t = 0; t < turns; ++t) EXPECT_NEAR(found[D + t], 0, 1e-12);  // symmetric
    EXPECT_NEAR(found[D + turns], area, 1e-12);
    EXPECT_NEAR(found[D + turns + 1], 2 + 3 * at, 1e-12);  // stress_xx
  }
  if constexpr (D > 1) {  // across y the stress 2 + 3 x bends: M = -3 I about the centre
    const std::vector<double> found =
        section_probe<D>(simulation.problem(), 1, 0.5).measure(simulation);
    // Particles stand for pieces of the width w = side / 8: their own moment is missing.
    const double inertia = std::pow(side, 3) / 12 * (1 - 1.0 / 64) * std::pow(side, D - 2);
    EXPECT_NEAR(found[1], 3.5 * area, 1e-12);
    EXPECT_NEAR(found[D + (D == 3 ? 2 : 0)], 3 * inertia, 1e-12);
  }
  const std::vector<double> outside =
      section_probe<D>(simulation.problem(), 0, 0.999).measure(simulation);
  EXPECT_EQ(outside[0], 0);
  EXPECT_TRUE(std::isnan(outside.back()));
}

// All sections at planes of nodes count each particle once.
TYPED_TEST(Probes, SectionsArePartitions) {
  constexpr int D = TypeParam::value;
  Vector<D> a;
  Matrix<D> B;
  Simulation<D> simulation = linear_block<D>(a, B);
  double volume = 0, all = 0;
  for (std::size_t p = 0; p < simulation.particles().size(); ++p)
    all += simulation.particles().volume(p);
  for (int plane = 0; plane <= 6; ++plane) {
    const Probe<D> probe = section_probe<D>(simulation.problem(), 0, plane / 6.0);
    const std::size_t column = static_cast<std::size_t>(
        std::find(probe.columns.begin(), probe.columns.end(), "area") - probe.columns.begin());
    volume += probe.measure(simulation)[column] / 6;
  }
  EXPECT_NEAR(volume, all, 1e-12 * all);
}

// Reactions are what momentum lacks: that of the particles changes by k (gravity + loads +
// reactions).
TYPED_TEST(Probes, ReactionsAreWhatMomentumLacks) {
  constexpr int D = TypeParam::value;
  for (const char* name : {"mpm", "cpdi1", "bspline2", "apic", "xpic"}) {
    Problem<D> problem = block<D>(6, 1.0 / 6, 5.0 / 6, name);
    problem.gravity = Vector<D>::LinSpaced(1, 2);
    problem.boundaries = {{0, 1.0 / 6, {}}, {0, 5.0 / 6, {}}};
    problem.boundaries[0].velocity.fill(0.0);
    problem.boundaries[1].velocity[0] = 0.25;
    problem.loads.push_back(point_load<D>(3, Vector<D>::Ones() * 20, [](double) { return 1.0; }));
    problem.damping = {0.3, 0.2};
    std::mt19937 random(3);
    for (std::size_t p = 0; p < problem.particles.size(); ++p)
      for (int d = 0; d < D; ++d) problem.particles.v[p][d] = uniform(random, -1, 1);
    Simulation<D> simulation(problem);
    const Probe<D> left = reaction_probe<D>(problem, 0), right = reaction_probe<D>(problem, 1);
    const auto momentum = [&] {
      Vector<D> sum = Vector<D>::Zero();
      for (std::size_t p = 0; p < simulation.particles().size(); ++p)
        sum += simulation.particles().mass[p] * simulation.particles().v[p];
      return sum;
    };
    const bool flip = std::string(name) != "apic" && std::string(name) != "xpic";
    for (int step = 0; step < 3; ++step) {
      simulation.map();
      const Vector<D> before = momentum();
      const Nodes<D> nodes = simulation.nodes();
      Vector<D> outside = Vector<D>::Zero(), gained = Vector<D>::Zero(), slowed = Vector<D>::Zero();
      for (std::size_t i = 0; i < nodes.mass.size(); ++i) {
        outside += nodes.mass[i] * problem.gravity;
        slowed += nodes.mass[i] * nodes.damping[i];
        gained += nodes.mass[i] * nodes.acceleration[i];
      }
      const ExternalForces<D> external = external_forces(simulation);
      for (const Vector<D>& load : external.loads) outside += load;
      // Nodes lighter than 1e-10 of the heaviest do not feel their forces, which so are lacking.
      std::vector<Vector<D>> unfelt(nodes.mass.size(), Vector<D>::Zero());
      for (std::size_t i = 0; i < nodes.mass.size(); ++i)
        if (!(nodes.mass[i] > 1e-10 * nodes.heaviest())) unfelt[i] = nodes.force[i];
      for (const Reaction& each : external.reactions) unfelt[each.node][each.axis] = 0;
      for (const Vector<D>& each : unfelt) outside -= each;
      for (const auto* each : {&left, &right}) {
        const std::vector<double> force = each->measure(simulation);
        for (int d = 0; d < D; ++d) outside[d] += force[d];
      }
      const double size = outside.norm() + 100;
      EXPECT_LE((gained - outside - slowed).norm(), 1e-10 * size) << name;
      const double dt = 1e-4, kick = problem.method.kick(simulation.last_step(), dt);
      simulation.step(dt);
      if (flip) {
        EXPECT_LE((momentum() - before - kick * (outside + slowed)).norm(), 1e-12 * size) << name;
      }
    }
  }
}

class MpmProbes : public InFolder {};

const std::string base = R"([grid]
lower = [0.0, 0.0]
upper = [1.0, 1.0]
cells = 8
[material]
young = 1000
poisson = 0.3
density = 1000
[[body]]
shape = "box"
lower = [0.25, 0.0]
upper = [0.75, 0.5]
[[boundary]]
axis = "y"
at = 0
kind = "fixed"
[loads]
gravity = [0, -1]
[method]
name = "cpdi1"
[time]
end = 0.1
rule = "fixed"
step = 0.004
[output]
frames = 2
)";

std::string answer(const std::string& text) {
  try {
    read_problem_text(text, "p.toml");
  } catch (const FileError& error) {
    return error.what();
  }
  return "";
}

TEST_F(MpmProbes, RowsAreThoseOfTheSteps) {
  const std::string probes =
      "[[probe]]\nkind = \"particle\"\nname = \"tip\"\nat = [0.74, 0.49]\n"
      "fields = [\"displacement\", \"id\"]\n"
      "[[probe]]\nkind = \"point\"\nat = [0.9, 0.9]\nfields = [\"velocity\"]\n"
      "[[probe]]\nkind = \"section\"\naxis = \"y\"\nat = 0.25\n"
      "[[probe]]\nkind = \"reaction\"\nboundary = 1\n";
  const auto rows = [&](const std::string& output) {
    const auto file = std::get<ProblemFile<2>>(read_problem_text(base + output + probes, "p.toml"));
    RunOptions options;
    options.folder = folder_;
    options.overwrite = true;
    run(file, options);
    return read_particles(folder_ / "probes.csv");
  };
  const ParticleTable all = rows("");
  EXPECT_EQ(all.column("step").size(), 26u);
  std::ifstream file(folder_ / "probes.csv");
  std::string header, first;
  std::getline(file, header);
  std::getline(file, first);
  EXPECT_THAT(header,
              HasSubstr("step,time,tip.displacement_x,tip.displacement_y,tip.id,point1.velocity_x,"
                        "point1.velocity_y,section1.force_x,section1.force_y,section1.moment_z,"
                        "section1.area,section1.stress_xx,"));
  EXPECT_THAT(header, HasSubstr("section1.stress_zz,reaction1.force_x,reaction1.force_y"));
  EXPECT_THAT(first, HasSubstr("0,0,0,0,63,,,0,0,0,0.5,"));  // no data: empty cells
  EXPECT_LT(all.column("tip.displacement_y").back(), 0);
  EXPECT_THAT(rows("probe_every = 10\n").column("step"), ElementsAre(0, 10, 20, 25));
  EXPECT_THAT(rows("probe_interval = 0.03\n").column("step"), ElementsAre(0, 8, 15, 23, 25));
}

TEST_F(MpmProbes, MistakesAreAnswered) {
  const auto probe = [](const std::string& keys) { return answer(base + "[[probe]]\n" + keys); };
  EXPECT_EQ(probe("kind = \"particle\"\nat = [0.5, 0.25]\n"), "");
  EXPECT_THAT(probe("at = [0.5, 0.25]\n"), HasSubstr("probe 1.kind: is missing"));
  EXPECT_THAT(
      probe("kind = \"partikle\"\n"),
      AllOf(HasSubstr("p.toml:28: probe 1.kind: unknown 'partikle'"), HasSubstr("'particle'")));
  EXPECT_THAT(probe("kind = \"particle\"\nat = [0.1, 0.25]\n"),
              AllOf(HasSubstr("p.toml:29: probe 1.at"), HasSubstr("lies in no body"),
                    HasSubstr("(0.28125, 0.21875)")));
  EXPECT_THAT(probe("kind = \"particle\"\nat = [0.5]\n"), HasSubstr("2 values are needed"));
  EXPECT_THAT(probe("kind = \"particle\"\nat = [0.5, 0.25]\nfields = [\"presure\"]\n"),
              AllOf(HasSubstr("probe 1.fields"), HasSubstr("pressure")));
  EXPECT_THAT(probe("kind = \"particle\"\nat = [0.5, 0.25]\nfields = []\n"),
              HasSubstr("must be at least one"));
  EXPECT_THAT(probe("kind = \"particle\"\nat = [0.5, 0.25]\nradius = 1\n"),
              HasSubstr("probe 1.radius: has no meaning"));
  EXPECT_THAT(probe("kind = \"point\"\nat = [0.5, 2]\n"), HasSubstr("must lie in the grid"));
  EXPECT_THAT(probe("kind = \"point\"\nat = [0.5, 0.2]\nradius = 0\n"),
              HasSubstr("probe 1.radius: radius = 0: must be positive"));
  EXPECT_THAT(probe("kind = \"point\"\nat = [0.5, 0.2]\nfields = [\"id\"]\n"),
              HasSubstr("has no meaning between particles"));
  EXPECT_THAT(probe("kind = \"section\"\naxis = \"z\"\nat = 0.5\n"), HasSubstr("'x' or 'y'"));
  EXPECT_THAT(probe("kind = \"section\"\naxis = \"x\"\nat = 1.5\n"),
              HasSubstr("probe 1.at: at = 1.5: must lie in the grid"));
  EXPECT_THAT(probe("kind = \"reaction\"\nboundary = 2\n"), HasSubstr("probe 1.boundary"));
  EXPECT_THAT(probe("kind = \"reaction\"\n"), HasSubstr("probe 1.boundary: is missing"));
  EXPECT_THAT(probe("kind = \"reaction\"\nboundary = 1\nname = \"a,b\"\n"),
              HasSubstr("probe 1.name: 'a,b' must be letters"));
  EXPECT_THAT(probe("kind = \"reaction\"\nboundary = 1\nname = \"a\"\n[[probe]]\n"
                    "kind = \"reaction\"\nboundary = 1\nname = \"a\"\n"),
              HasSubstr("probe 2.name: 'a' is another probe"));
  EXPECT_THAT(answer(base + "probe_every = 0\n"), HasSubstr("output.probe_every"));
  EXPECT_THAT(answer(base + "probe_interval = -1\n"), HasSubstr("must be positive"));
  EXPECT_THAT(answer(base + "probe_interval = 1\nprobe_every = 2\n"), HasSubstr("only one"));
}

}  // namespace
}  // namespace recon::mpm::test
