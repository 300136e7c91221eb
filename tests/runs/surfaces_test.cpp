// Tractions on surfaces and what boundaries hold, from problem files.
#include <gmock/gmock.h>

#include <cmath>
#include <map>
#include <numbers>

#include "recon/runs/compose.hpp"
#include "recon/runs/run.hpp"
#include "runs/support.hpp"

namespace recon::mpm::test {
namespace {

using testing::HasSubstr;

template <int D>
ProblemFile<D> from_text(const std::string& text) {
  return std::get<ProblemFile<D>>(read_problem_text(text, "p.toml"));
}
std::string complaint(const std::string& text) {
  try {
    read_problem_text(text, "p.toml");
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

constexpr double pi = std::numbers::pi;

// The error of the displacement, root mean square, over the amplitude, where exact(X) is that of
// the end over the amplitude.
template <int D, class Exact>
double error_of(const ProblemFile<D>& file, double amplitude, const Exact& exact) {
  Simulation<D> simulation(file.problem);
  run_until(simulation, file.problem.time.end);
  const Particles<D>& now = simulation.particles();
  double sum = 0;
  for (std::size_t p = 0; p < now.size(); ++p)
    sum += ((now.x[p] - now.X[p]) / amplitude - exact(now.X[p])).squaredNorm();
  return std::sqrt(sum / static_cast<double>(now.size()));
}

// u = G sin(pi X) sin(pi t) in a bar on rollers at 0, under the traction -G pi sin(pi t) at 1.
std::string pulled_bar(const std::string& method, int cells) {
  return "[grid]\nlower = [0]\nupper = [1.5]\ncells = " + std::to_string(cells) +
         "\n[material]\nyoung = 1\npoisson = 0\ndensity = 1\n[[body]]\nshape = \"box\"\n"
         "lower = [0]\nupper = [1]\nvelocity = [\"1e-5 * pi * sin(pi * X)\"]\n"
         "[[boundary]]\naxis = \"x\"\nat = 0\nkind = \"roller\"\n"
         "[[pressure]]\nside = \"x_upper\"\nmagnitude = \"1e-5 * pi * sin(pi * t)\"\n"
         "[method]\nname = \"" +
         method +
         "\"\n"
         "[time]\nend = 0.5\nrule = \"bar_wave\"\ncourant = 0.2\n";
}
double bar_order(const std::string& method) {
  double error[2];
  for (const int finer : {0, 1})
    error[finer] = error_of<1>(from_text<1>(pulled_bar(method, finer ? 64 : 32)), 1e-5,
                               [](const Vector<1>& X) { return Vector<1>(std::sin(pi * X[0])); });
  return std::log2(error[0] / error[1]);
}

class SurfaceOfEveryMethod : public testing::TestWithParam<Method> {};
INSTANTIATE_TEST_SUITE_P(Mpm, SurfaceOfEveryMethod, testing::ValuesIn(methods()),
                         [](const auto& each) { return each.param.name; });

// Two methods are of less: mls_mpm, whose gradients are not those of any functions, so that no load
// meets the forces of stresses at the surface exactly; and xpic, whose filter takes a slope of the
// velocity at the end for a part that particles do not see.
TEST_P(SurfaceOfEveryMethod, TractionIsOfSecondOrder) {
  if (GetParam().basis == Basis::q8) return;  // is for 2-D
  const double order = bar_order(GetParam().name);
  const bool less = GetParam().name == "mls_mpm" || GetParam().name == "xpic";
  EXPECT_GE(order, less ? 1.5 : 1.75) << GetParam().name;
  EXPECT_LE(order, 2.3) << GetParam().name;
}

// On a turned and sheared body, nodes get the resultant and the moment of the tractions, whatever
// functions and domains are. What is summed here is F N A0 about the places on the surface.
TEST_P(SurfaceOfEveryMethod, ResultantAndMomentAreExact) {
  const std::string text =
      "[grid]\nlower = [0, 0]\nupper = [2, 2]\ncells = 8\n[material]\nyoung = 1\npoisson = 0.3\n"
      "density = 1\n[[body]]\nshape = \"box\"\nlower = [0.5, 0.75]\nupper = [1.25, 1.25]\n"
      "[[traction]]\nside = \"x_upper\"\ntraction = [\"X + y\", 2]\n"
      "[[traction]]\nside = \"y_lower\"\ntraction = [\"-x\", \"1 + t\"]\narea = \"current\"\n"
      "[[pressure]]\nside = \"y_upper\"\nmagnitude = \"1 + X * Y\"\n"
      "[method]\nname = \"" +
      GetParam().name + "\"\n[time]\nend = 1\n";
  ProblemFile<2> file = from_text<2>(text);
  Particles<2>& particles = file.problem.particles;
  Matrix<2> F;
  F << 1.1, 0.2, -0.15, 0.95;
  const Vector<2> middle(0.9, 1);
  for (std::size_t p = 0; p < particles.size(); ++p) {
    particles.F[p] = F;
    particles.x[p] = middle + F * (particles.X[p] - middle);
  }
  Simulation<2> simulation(file.problem);
  simulation.map();
  Vector<2> force = Vector<2>::Zero(), exact = force;
  double moment = 0, exact_moment = 0;
  for (std::size_t i = 0; i < file.problem.grid.size(); ++i) {
    const Vector<2> f = simulation.nodes().force[i], x = file.problem.grid.position(i);
    force += f;
    moment += x[0] * f[1] - x[1] * f[0];
  }
  const auto add = [&](const Vector<2>& X, const Vector<2>& f) {
    const Vector<2> x = middle + F * (X - middle);
    exact += f;
    exact_moment += x[0] * f[1] - x[1] * f[0];
  };
  const double edge = 1.0 / 32, half = edge;  // half the length of a face
  const auto place = [&](const Vector<2>& X) -> Vector<2> { return middle + F * (X - middle); };
  for (double y = 0.75 + half; y < 1.25; y += 2 * edge) {
    const Vector<2> X(1.25, y);
    add(X, 2 * edge * Vector<2>(X[0] + place(X)[1], 2));
  }
  const Matrix<2> nanson = F.determinant() * F.inverse().transpose();
  for (double x = 0.5 + half; x < 1.25; x += 2 * edge) {
    const Vector<2> below(x, 0.75), above(x, 1.25);
    const double stretched = (nanson * Vector<2>(0, -1)).norm();
    add(below, 2 * edge * stretched * Vector<2>(-place(below)[0], 1));
    add(above, -2 * edge * (1 + above.prod()) * (nanson * Vector<2>(0, 1)));
  }
  EXPECT_LE((force - exact).norm(), 1e-13) << GetParam().name;
  EXPECT_NEAR(moment, exact_moment, 1e-13) << GetParam().name;
}

// A standing shear wave u_x = G sin(pi Y) sin(w t), w = pi sqrt(mu / density), in a block that
// nothing else holds: tangential tractions on all four sides.
std::string shear_wave(const std::string& method, int cells) {
  std::string text =
      "[constants]\nG = 1e-5\nmu = 0.5\nw = \"pi * sqrt(mu)\"\n"
      "[grid]\nlower = [-0.5, -0.5]\nupper = [1.5, 1.5]\ncells = " +
      std::to_string(cells) +
      "\n[material]\nyoung = 1\npoisson = 0\ndensity = 1\n[[body]]\nshape = \"box\"\n"
      "lower = [0, 0]\nupper = [1, 1]\nvelocity = [\"G * w * sin(pi * Y)\", 0]\n"
      "[method]\nname = \"" +
      method +
      "\"\n"
      "[time]\nend = 0.7\nrule = \"bar_wave\"\ncourant = 0.2\n";
  for (const char* side : {"x_lower", "x_upper", "y_lower", "y_upper"}) {
    const std::string value = std::string("\"") +
                              (std::string(side).ends_with("lower") ? "-" : "") +
                              "mu * G * pi * cos(pi * Y) * sin(w * t)\"";
    text += std::string("[[traction]]\nside = \"") + side +
            "\"\ntraction = " + (side[0] == 'x' ? "[0, " + value + "]\n" : "[" + value + ", 0]\n");
  }
  return text;
}
TEST(Surfaces, TangentialTractionIsOfSecondOrder) {
  const double amplitude = std::sin(pi * std::sqrt(0.5) * 0.7);
  for (const char* method : {"mpm", "cpdi1", "cpls", "bspline2", "impm", "affine_cpdi2"}) {
    double error[2];
    for (const int finer : {0, 1})
      error[finer] = error_of<2>(
          from_text<2>(shear_wave(method, finer ? 32 : 16)), 1e-5,
          [&](const Vector<2>& X) { return Vector<2>(amplitude * std::sin(pi * X[1]), 0); });
    EXPECT_GE(std::log2(error[0] / error[1]), 1.75) << method;
    EXPECT_LE(std::log2(error[0] / error[1]), 2.3) << method;
  }
}

// A bar whose end is moved as that of u = G cos(pi X) sin(pi t): in every scheme and order of the
// stress of second order, and for FLIP and PIC.
std::string moved_bar(const std::string& method, int cells) {
  return "[constants]\nG = 1e-5\n[grid]\nlower = [-0.5]\nupper = [1.5]\ncells = " +
         std::to_string(cells) +
         "\n[material]\nyoung = 1\npoisson = 0\ndensity = 1\n[[body]]\nshape = \"box\"\n"
         "lower = [0]\nupper = [1]\nvelocity = [\"G * pi * cos(pi * X)\"]\n"
         "[[boundary]]\naxis = \"x\"\nat = 0\nkind = \"velocity\"\n"
         "velocity = [\"G * pi * cos(pi * (t + x))\"]\n"  // x is 0 at the node
         "[method]\nname = \"" +
         method +
         "\"\n"
         "[time]\nend = 0.5\nrule = \"bar_wave\"\ncourant = 0.2\n";
}
TEST(Boundaries, MovedEndsAreOfSecondOrder) {
  for (const char* method : {"mpm", "cpdi1", "cpls", "mpm+musl", "cpdi1+stress=first", "impm",
                             "apic", "ugimp+runge_kutta", "xpic"}) {
    double error[2];
    for (const int finer : {0, 1})
      error[finer] = error_of<1>(from_text<1>(moved_bar(method, finer ? 64 : 32)), 1e-5,
                                 [](const Vector<1>& X) { return Vector<1>(std::cos(pi * X[0])); });
    EXPECT_GE(std::log2(error[0] / error[1]), 1.75) << method << " " << error[1];
    EXPECT_LE(std::log2(error[0] / error[1]), 2.3) << method << " " << error[1];
  }
}

// Held nodes have the velocity of the time of the velocities, before the kick and after it, and a
// run that goes on from a state is the run in one piece.
TEST(Boundaries, MovedNodesHaveTheirVelocity) {
  for (const char* method : {"mpm", "mpm+musl", "cpdi1+stress=first", "mpm+symplectic_euler"}) {
    const auto file = from_text<1>(moved_bar(method, 16));
    Simulation<1> simulation(file.problem), other(file.problem);
    const std::size_t node = 8;
    const auto held = [](double t) { return 1e-5 * pi * std::cos(pi * t); };
    for (const double dt : {0.01, 0.004, 0.007}) {
      simulation.map();
      const double before = simulation.time() - simulation.velocity_lag();
      EXPECT_NEAR(simulation.nodes().velocity[node][0], held(before), 1e-20) << method;
      other.restore(simulation.state());
      other.step(dt);
      simulation.step(dt);
      const double after = simulation.time() - simulation.velocity_lag();
      EXPECT_NEAR(simulation.nodes().velocity[node][0], held(after), 1e-20) << method;
      EXPECT_EQ(other.particles().x, simulation.particles().x) << method;
      EXPECT_EQ(other.particles().v, simulation.particles().v) << method;
    }
  }
}

// A part of a plane holds its nodes and no others.
TEST(Boundaries, PartsOfPlanes) {
  const std::string text =
      "[grid]\nlower = [0, 0]\nupper = [1, 1]\ncells = 8\n[material]\nyoung = 1\npoisson = 0\n"
      "density = 1\n[[body]]\nshape = \"box\"\nlower = [0, 0]\nupper = [1, 1]\nvelocity = [1, 2]\n"
      "[[boundary]]\naxis = \"x\"\nat = 0.5\nkind = \"velocity\"\nvelocity = [\"free\", \"3 * "
      "y\"]\n"
      "from = [0, 0.25]\nto = [0, 0.625]\n[method]\nname = \"mpm\"\n[time]\nend = 1\n";
  const auto file = from_text<2>(text);
  Simulation<2> simulation(file.problem);
  simulation.map();
  int held = 0;
  for (std::size_t i = 0; i < file.problem.grid.size(); ++i) {
    const Vector<2> x = file.problem.grid.position(i), v = simulation.nodes().velocity[i];
    const bool in_part = x[0] == 0.5 && x[1] > 0.24 && x[1] < 0.63;
    held += in_part;
    EXPECT_NEAR(v[0], 1, 1e-14);
    EXPECT_NEAR(v[1], in_part ? 3 * x[1] : 2, 1e-14);
  }
  EXPECT_EQ(held, 4);
}

// What is wrong is answered with the key.
TEST(Surfaces, MistakesAreAnswered) {
  const std::string good =
      "[grid]\nlower = [0, 0]\nupper = [1, 1]\ncells = 8\n[material]\nyoung = 1\npoisson = 0\n"
      "density = 1\n[[body]]\nshape = \"box\"\nlower = [0, 0]\nupper = [0.5, 0.5]\n"
      "[method]\nname = \"mpm\"\n[time]\nend = 1\n";
  EXPECT_EQ(complaint(good), "");
  const std::string traction = good + "[[traction]]\nside = \"x_upper\"\n";
  EXPECT_EQ(complaint(traction + "traction = [1, 0]\n"), "");
  EXPECT_EQ(complaint(traction + "traction = [1, \"X + t\"]\narea = \"current\"\n"), "");
  EXPECT_THAT(complaint(traction), HasSubstr("traction"));
  EXPECT_THAT(complaint(traction + "traction = [1]\n"), HasSubstr("traction"));
  EXPECT_THAT(complaint(traction + "traction = [1, \"nonsense\"]\n"), HasSubstr("nonsense"));
  EXPECT_THAT(complaint(traction + "traction = [1, 0]\narea = \"refrence\"\n"),
              HasSubstr("reference"));
  EXPECT_THAT(complaint(traction + "traction = [1, 0]\nmagnitude = 1\n"), HasSubstr("magnitude"));
  const std::string plane = good + "[[boundary]]\naxis = \"x\"\n";
  EXPECT_EQ(complaint(plane + "at = 0\nkind = \"symmetry\"\n"), "");
  EXPECT_THAT(complaint(plane + "at = 0.5\nkind = \"symmetry\"\n"), HasSubstr("face of the grid"));
  EXPECT_THAT(complaint(plane + "at = 0\nkind = \"symmetry\"\nfrom = [0, 0.5]\n"),
              HasSubstr("whole face"));
  EXPECT_THAT(complaint(plane + "at = 0\nkind = \"fixed\"\nfrom = [0, 0.3]\nto = [0, 0.35]\n"),
              HasSubstr("must leave nodes"));
  EXPECT_THAT(complaint(plane + "at = 0\nkind = \"fixed\"\nfrom = [0.3]\n"), HasSubstr("from"));
  EXPECT_THAT(complaint(plane + "at = 0\nkind = \"velocity\"\nvelocity = [\"fre\", 1]\n"),
              HasSubstr("fre"));
  std::string consistent = plane + "at = 0\nkind = \"velocity\"\nvelocity = [\"t\", 1]\n";
  EXPECT_EQ(complaint(consistent), "");
  consistent.replace(consistent.find("\"mpm\""), 5, "\"mpm+consistent\"");
  EXPECT_THAT(complaint(consistent), HasSubstr("must be lumped"));
  const auto polar = [&](const std::string& keys) {
    return "[grid]\nlower = [0, 0]\nupper = [1, 1]\ncells = 8\n[material]\nyoung = 1\npoisson = 0\n"
           "density = 1\n[[body]]\nshape = \"ring\"\ncentre = [0, 0]\ninner = 0.4\nouter = 0.9\n" +
           keys + "[method]\nname = \"mpm\"\n[time]\nend = 1\n";
  };
  EXPECT_EQ(complaint(polar("layout = \"polar\"\nangles = [0, 90]\n")), "");
  EXPECT_THAT(complaint(polar("layout = \"polar\"\n")), HasSubstr("no body is cut"));
  EXPECT_THAT(complaint(polar("layout = \"polar\"\nangles = [-1, 90]\n")),
              HasSubstr("no body is cut"));
  EXPECT_THAT(complaint(polar("layout = \"polar\"\nangles = [90, 0]\n")), HasSubstr("angles"));
  EXPECT_THAT(complaint(good + "[[body]]\nshape = \"disk\"\ncentre = [0.5, 0.5]\n"
                               "radius = 0.2\nangles = [0, 90]\n"),
              HasSubstr("angles"));
}

// A quarter of a ring is a quarter of it, and a pressure on a round side acts on the circle.
TEST(Surfaces, RoundSidesHaveTheirArea) {
  const auto read = [](const std::string& keys) {
    return from_text<2>(
        "[grid]\nlower = [-1, -1]\nupper = [1, 1]\ncells = 8\n[material]\nyoung = 1\npoisson = 0\n"
        "density = 1\n[[body]]\nshape = \"ring\"\ncentre = [0, 0]\ninner = 0.4\nouter = 0.9\n"
        "layout = \"polar\"\nangular = 6\n" +
        keys +
        "[[pressure]]\nside = \"inner\"\nmagnitude = 1\n[method]\nname = \"cpdi1\"\n"
        "[time]\nend = 1\n");
  };
  for (const double part : {1.0, 0.25}) {
    const auto file = read(part == 1 ? "" : "angles = [0, 90]\n");
    double area = 0, volume = 0;
    for (const auto& load : file.problem.loads) area += load.area.norm();
    for (const double each : file.problem.particles.volume0) volume += each;
    EXPECT_NEAR(area, part * 2 * pi * 0.4, 1e-12);
    EXPECT_NEAR(volume, part * pi * (0.81 - 0.16), 1e-12);
  }
}

// A quarter of a block between planes of symmetry moves as the quarter of the whole one does, where
// functions end at the faces of the grid as they go on in a mirror.
TEST(Symmetry, AQuarterIsAQuarterOfTheWhole) {
  const auto read = [](const std::string& method, bool whole) {
    const std::string least = whole ? "-1" : "0";
    std::string text =
        "[grid]\nlower = [" + least + ", " + least +
        "]\nupper = [1, 1]\ncells = 10\n"
        "[material]\nyoung = 100\npoisson = 0.3\ndensity = 1\n[[body]]\nshape = \"box\"\n"
        "lower = [" +
        (whole ? "-0.5, -0.5" : "0, 0") +
        "]\nupper = [0.5, 0.5]\n"
        "velocity = [\"sin(2 * X) * cos(Y)\", \"-cos(3 * X) * sin(Y)\"]\n"
        "[loads]\nbody_force = [\"X * cos(Y)\", \"Y * cos(X)\"]\n"
        "[method]\nname = \"" +
        method + "\"\n[time]\nend = 1\n";
    for (const char* axis : {"x", "y"})
      if (!whole)
        text += std::string("[[boundary]]\naxis = \"") + axis + "\"\nat = 0\nkind = \"symmetry\"\n";
    return from_text<2>(text);
  };
  for (const char* method :
       {"mpm", "impm", "impm+degree=2", "imls_mpm", "wls", "hopic", "cpdi1+cpls", "cpdi1+mls"}) {
    const auto whole = read(method, true), quarter = read(method, false);
    Simulation<2> of_whole(whole.problem), of_quarter(quarter.problem);
    of_whole.map();
    of_quarter.map();
    for (std::size_t i = 0; i < quarter.problem.grid.size(); ++i) {
      const Vector<2> x = quarter.problem.grid.position(i);
      const auto j = whole.problem.grid.number({static_cast<int>(std::lround(10 * x[0])) + 10,
                                                static_cast<int>(std::lround(10 * x[1])) + 10});
      if (of_quarter.nodes().mass[i] == 0) continue;
      EXPECT_LE((of_quarter.nodes().velocity[i] - of_whole.nodes().velocity[j]).norm(), 1e-13)
          << method << " at " << x.transpose();
      EXPECT_LE((of_quarter.nodes().acceleration[i] - of_whole.nodes().acceleration[j]).norm(),
                1e-11)
          << method << " at " << x.transpose();
    }
    // Domains reach beyond the planes by a little when they are deformed: points do not.
    if (quarter.problem.method.domain != Domain::point) continue;
    for (int step = 0; step < 20; ++step) {
      of_whole.step(1e-3);
      of_quarter.step(1e-3);
    }
    std::map<std::pair<double, double>, std::size_t> number;
    const auto key = [](const Vector<2>& X) {
      return std::pair{std::round(1e6 * X[0]), std::round(1e6 * X[1])};
    };
    for (std::size_t p = 0; p < of_whole.particles().size(); ++p)
      number[key(of_whole.particles().X[p])] = p;
    for (std::size_t p = 0; p < of_quarter.particles().size(); ++p) {
      const std::size_t q = number.at(key(of_quarter.particles().X[p]));
      EXPECT_LE((of_quarter.particles().x[p] - of_whole.particles().x[q]).norm(), 1e-12) << method;
      EXPECT_LE((of_quarter.particles().stress[p] - of_whole.particles().stress[q]).norm(), 1e-8)
          << method;
    }
  }
}

}  // namespace
}  // namespace recon::mpm::test
