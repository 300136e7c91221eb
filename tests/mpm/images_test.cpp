// Boundaries with images of particles, and periods: they are what mirrored bodies, held nodes and
// more periods are.
#include <cmath>

#include "mpm/support.hpp"
#include "recon/runs/compose.hpp"
#include "recon/runs/ledger.hpp"

namespace recon::mpm::test {
namespace {

constexpr double cells = 6;  // of the body along an axis

// A body of 6 cells along each axis, at `offset` cells from the lower corner of a grid with room on
// all sides, with a velocity field that differs from place to place.
template <int D>
Problem<D> wavy(const std::string& method, double offset, int on_grid = 16) {
  Problem<D> problem;
  constexpr double h = 0.1;
  problem.grid = Grid<D>(Vector<D>::Zero(), Vector<D>::Constant(on_grid * h), h);
  problem.materials = {NeoHookean{Lame::from(1000, 0.3)}};
  problem.densities = {1000};
  problem.method = composed(method);
  int all = 1;
  for (int d = 0; d < D; ++d) all *= static_cast<int>(2 * cells);
  for (int i = 0; i < all; ++i) {
    Vector<D> X;
    for (int d = 0, rest = i; d < D; ++d, rest /= static_cast<int>(2 * cells))
      X[d] = (offset + (rest % static_cast<int>(2 * cells) + 0.5) / 2) * h;
    problem.particles.add(X, Matrix<D>::Identity() * (h / 4), 1000, 0);
  }
  for (std::size_t p = 0; p < problem.particles.size(); ++p) {
    const Vector<D> X = problem.particles.X[p] / h;
    for (int d = 0; d < D; ++d)
      problem.particles.v[p][d] =
          0.1 * std::sin(1 + X.sum() + 2 * X[d]) + 0.05 * std::cos(3 * X[0]);
  }
  return problem;
}

template <int D>
Boundary<D> wall(int axis, double at, bool fixed, bool images) {
  Boundary<D> boundary;
  boundary.axis = axis;
  boundary.at = at;
  boundary.images = images;
  if (fixed)
    boundary.velocity.fill(0.0);
  else
    boundary.velocity[axis] = 0.0;
  return boundary;
}

// Positions, velocities and stresses after some steps, of the first `count` particles.
template <int D>
void expect_same_motion(const Problem<D>& a, const Problem<D>& b, double tolerance, int steps) {
  State<D> one = start(a), other = start(b);
  Step<D> step_one(a), step_other(b);
  const std::size_t count = std::min(one.particles.size(), other.particles.size());
  for (int i = 0; i < steps; ++i) {
    step_one(one, 0.01);
    step_other(other, 0.01);
  }
  double x = 0, v = 0, stress = 0, moved = 0;
  for (std::size_t p = 0; p < count; ++p) {
    const Vector<D> u = one.particles.x[p] - one.particles.X[p];
    x = std::max(x, (other.particles.x[p] - other.particles.X[p] - u).norm());
    v = std::max(v, (other.particles.v[p] - one.particles.v[p]).norm());
    stress = std::max(stress, (other.particles.stress[p] - one.particles.stress[p]).norm());
    moved = std::max(moved, u.norm());
  }
  EXPECT_GT(moved, 1e-3) << a.method.name;
  EXPECT_LE(x, tolerance * 0.1) << a.method.name;
  EXPECT_LE(v, tolerance * 0.1) << a.method.name;
  EXPECT_LE(stress, tolerance * 1000) << a.method.name;
}

bool takes_images(const Method& method) {
  return method.velocity != VelocityMap::polynomial && method.basis != Basis::q8;
}

// What goes to the nodes beside a roller with images is what the other half of a body gives that is
// symmetric in its plane, wherever that lies between the nodes, for every method.
TEST(ImagesInARoller, GiveWhatTheOtherHalfOfTheBodyGives) {
  for (const Method& method : methods()) {
    if (!takes_images(method)) continue;
    Problem<2> half = wavy<2>(method.name, 8.37, 20);
    for (std::size_t p = 0; p < half.particles.size(); ++p) {
      half.particles.F[p] = Matrix<2>{{1.05, 0.02}, {0.03 + 0.01 * std::sin(p), 0.97}};
      half.particles.stress[p] = Matrix<2>{{20, 5 + std::cos(p)}, {5 + std::cos(p), -10}};
      half.particles.L[p] = Matrix<2>{{0.1, 0.4}, {-0.2, std::sin(2 * p)}};
    }
    // A load on the surface of the particle next to the plane.
    Load<2> load{
        0, {0.02, 0.01}, {}, [](const LoadedPlace<2>&, double) { return Vector<2>(3, 7); }};
    load.area.setZero();
    half.loads = {load};
    Problem<2> whole = half;
    load.particle = half.particles.size();
    load.offset[0] = -0.02;
    load.force = [](const LoadedPlace<2>&, double) { return Vector<2>(-3, 7); };
    whole.loads.push_back(load);
    const double at = 0.837;
    half.boundaries = {wall<2>(0, at, false, true)};
    const Particles<2> one = half.particles;
    const Matrix<2> R = Vector<2>(-1, 1).asDiagonal();
    for (std::size_t p = 0; p < one.size(); ++p) {
      Vector<2> X = one.X[p];
      X[0] = 2 * at - X[0];
      whole.particles.add(X, one.half_edges[p], 1000, 0);
      whole.particles.v.back() = R * one.v[p];
      whole.particles.F.back() = R * one.F[p] * R;
      whole.particles.stress.back() = R * one.stress[p] * R;
      whole.particles.L.back() = R * one.L[p] * R;
    }
    Step<2> of_half(half), of_whole(whole);
    State<2> half_state = start(half), whole_state = start(whole);
    of_half.to_nodes(half_state);
    of_whole.to_nodes(whole_state);
    const Nodes<2>&images = of_half.nodes(), &bodies = of_whole.nodes();
    double heaviest = bodies.heaviest();
    for (std::size_t i = 0; i < images.mass.size(); ++i) {
      if (half.grid.position(i)[0] < at - 0.1) continue;  // farther ones no particle sees
      EXPECT_NEAR(images.mass[i], bodies.mass[i], 1e-12 * heaviest) << method.name << i;
      EXPECT_LE((images.force[i] - bodies.force[i]).norm(), 1e-11 * 20) << method.name << i;
      if (std::abs(bodies.mass[i]) > 1e-6 * heaviest) {
        EXPECT_LE((images.mapped[i] - bodies.mapped[i]).norm(), 1e-9) << method.name << i;
      }
    }
  }
}

// Where the plane is one of nodes a half moves as the half of a whole body does, with every domain
// and update: what lies at images whose nodes lack images of their own is not for the particles.
TEST(ImagesInARoller, LetAHalfMoveAsTheWhole) {
  for (const char* method :
       {"mpm", "ugimp", "cpgimp", "cpdi1", "cpdi2", "bspline2", "bspline3", "mpm+runge_kutta",
        "cpdi1+runge_kutta", "bspline2+runge_kutta", "bspline3+runge_kutta", "bspline3+pic"}) {
    Problem<2> half = wavy<2>(method, 8, 20);
    half.boundaries = {wall<2>(0, 0.8, false, true)};
    Problem<2> whole = half;
    whole.boundaries.clear();
    for (std::size_t p = 0; p < half.particles.size(); ++p) {
      Vector<2> X = half.particles.X[p];
      X[0] = 1.6 - X[0];
      whole.particles.add(X, half.particles.half_edges[p], 1000, 0);
      whole.particles.v.back() = Vector<2>(-half.particles.v[p][0], half.particles.v[p][1]);
    }
    expect_same_motion(half, whole, 1e-9, 10);
  }
}

// What particles take through linear functions is the transpose of what they and their images give:
// the power of the nodes' forces is that of the stresses of both, -2 sum_p V sigma : L, for bodies
// within two cells of the plane, with all of their domains.
TEST(ImagesInARoller, TakeByTheTransposeOfWhatTheyGive) {
  for (const char* method : {"cpdi1", "cpdi2", "ugimp", "cpgimp", "cpdi1+velocity=taylor"})
    for (const double shift : {0.05, 0.2, 0.37, 0.5, 0.8}) {
      const Problem<2> whole = wavy<2>(method, 5 + shift, 17);
      Problem<2> problem = whole;
      problem.particles = {};
      const double at = 0.5 + 0.1 * shift;
      for (std::size_t p = 0; p < whole.particles.size(); ++p) {
        if (whole.particles.X[p][0] > at + 0.17) continue;
        problem.particles.add(whole.particles.X[p], whole.particles.half_edges[p], 1000, 0);
        problem.particles.v.back() = whole.particles.v[p];
        const double s = 5 + std::cos(static_cast<double>(p));
        problem.particles.stress.back() = Matrix<2>{{20, s}, {s, -10 * s}};
      }
      problem.boundaries = {wall<2>(0, at, false, true)};
      State<2> state = start(problem);
      Step<2> step(problem);
      step(state, 1e-3);
      double nodes = 0, particles = 0;
      for (std::size_t i = 0; i < problem.grid.size(); ++i)
        nodes += step.nodes().force[i].dot(step.nodes().velocity[i]);
      for (std::size_t p = 0; p < state.particles.size(); ++p)
        particles -= 2 * problem.particles.volume0[p] *
                     problem.particles.stress[p].cwiseProduct(state.particles.L[p]).sum();
      EXPECT_GT(std::abs(particles), 1e-3);
      EXPECT_NEAR(nodes, particles, 1e-9) << method << " " << shift;
    }
}

// A bar of `count` cells, from 0.5 to 1.1, that swings between walls with images, whose grid is
// shifted by this part of a cell.
Problem<1> swinging(const std::string& method, int count, double shift) {
  Problem<1> problem;
  const double h = 0.6 / count, lower = 0.5 - (5 + shift) * h;
  problem.grid = Grid<1>(Vector<1>(lower), Vector<1>(lower + (count + 11) * h), h);
  problem.materials = {NeoHookean{Lame::from(1000, 0.3)}};
  problem.densities = {1000};
  problem.method = composed(method);
  for (int i = 0; i < 2 * count; ++i) {
    const double X = 0.5 + (i + 0.5) * h / 2;
    problem.particles.add(Vector<1>(X), Matrix<1>(h / 4), 1000, 0);
    problem.particles.v.back()[0] = 0.05 * std::sin(std::acos(-1) * (X - 0.5) / 0.6);
  }
  problem.boundaries = {wall<1>(0, 0.5, false, true), wall<1>(0, 1.1, false, true)};
  return problem;
}

// So energy stays between walls of any place, to 1 % in five periods on 12 cells, with domains that
// follow their material and L of velocities that lose none. Not to rounding, unless the plane lies
// on nodes or in the middle between them: particles farther than two cells from it take what their
// own nodes have alone. Points, and boxes that keep their size, gain energy by that (docs/mpm.md).
TEST(ImagesInARoller, KeepEnergy) {
  for (const char* method : {"cpgimp+first", "cpdi1+first", "cpdi2+first"})
    for (const double shift : {0.0, 0.05, 0.2, 0.37, 0.5, 0.8}) {
      Simulation<1> simulation(swinging(method, 12, shift));
      simulation.map();
      const Ledger first = account(simulation);
      double off = 0;
      for (int i = 0; i < 1000; ++i) {
        simulation.step(0.005);
        simulation.map();
        off = std::max(off, std::abs(account(simulation, first).total() / first.total() - 1));
      }
      EXPECT_LE(off, 0.01) << method << " " << shift;
    }
}

// The account of a state has the accelerations and velocities that particles take in the next step.
TEST(ImagesInARoller, CountInTheAccount) {
  for (const char* method : {"mpm", "cpdi1", "bspline2"}) {
    Problem<1> problem = swinging(method, 6, 0.37);
    problem.gravity[0] = -2;
    constexpr double dt = 0.01;
    Simulation<1> simulation(problem);
    for (int i = 0; i < 20; ++i) simulation.step(dt);
    simulation.map();
    const Ledger ledger = account(simulation);
    const Particles<1> before = simulation.particles();
    simulation.step(dt);
    const Particles<1>& after = simulation.particles();
    double kinetic = 0, power = 0;
    for (std::size_t p = 0; p < before.size(); ++p) {
      const double m = before.mass[p], a = (after.v[p][0] - before.v[p][0]) / dt;
      kinetic += m / 2 * std::pow(before.v[p][0] + dt / 2 * a, 2);
      // Particles are moved by the velocity that nodes have half a step later.
      power += m * -2 * ((after.x[p][0] - before.x[p][0]) / dt - dt / 2 * a);
    }
    EXPECT_NEAR(ledger.kinetic, kinetic, 1e-12 * kinetic) << method;
    EXPECT_NEAR(ledger.power, power, 1e-9 * std::abs(power)) << method;
  }
}

// Runge-Kutta takes the same beside walls between nodes: from one state the deformation grows as in
// other updates, to the first order in the step.
TEST(ImagesInARoller, GiveRungeKuttaTheSameRates) {
  for (const char* method : {"mpm", "cpdi1"}) {
    Simulation<1> before(swinging(method, 6, 0.37));
    for (int i = 0; i < 20; ++i) before.step(0.01);
    constexpr double dt = 1e-6;
    std::vector<double> rates[2];
    for (const bool runge_kutta : {false, true}) {
      Problem<1> problem =
          swinging(std::string(method) + (runge_kutta ? "+runge_kutta" : ""), 6, 0.37);
      problem.particles = before.particles();
      Simulation<1> simulation(problem);
      simulation.step(dt);
      for (std::size_t p = 0; p < problem.particles.size(); ++p)
        rates[runge_kutta].push_back(
            (simulation.particles().F[p](0, 0) - problem.particles.F[p](0, 0)) / dt);
    }
    double largest = 0;
    for (const double rate : rates[0]) largest = std::max(largest, std::abs(rate));
    ASSERT_GT(largest, 0.01);
    for (std::size_t p = 0; p < rates[0].size(); ++p)
      EXPECT_NEAR(rates[0][p], rates[1][p], 1e-3 * largest) << method << " " << p;
  }
}

// Where the plane is one of nodes, points see through linear functions what held nodes give: the
// image of a roller, and of a wall that holds all components.
template <class T>
class ImagesAtNodes : public testing::Test {};
TYPED_TEST_SUITE(ImagesAtNodes, AllDimensions);
TYPED_TEST(ImagesAtNodes, GiveWhatHeldNodesGive) {
  constexpr int D = TypeParam::value;
  for (const bool fixed : {false, true})
    for (const char* method :
         {"mpm", "mpm+musl", "mpm+first", "mpm+affine+blend=0.1", "imls_mpm"}) {
      if (std::string(method) == "imls_mpm" && fixed) continue;  // fits: without images one-sided
      Problem<D> held = wavy<D>(method, 5);
      Problem<D> images = held;
      for (int d = 0; d < D; ++d) {
        held.boundaries.push_back(wall<D>(d, 0.5, fixed, false));
        images.boundaries.push_back(wall<D>(d, 0.5, fixed, true));
      }
      if (std::string(method) == "imls_mpm") {  // a plane of symmetry: a face of the grid
        held.grid = Grid<D>(Vector<D>::Constant(0.5), Vector<D>::Constant(1.6), 0.1);
        for (Boundary<D>& boundary : held.boundaries) boundary.symmetry = true;
      }
      expect_same_motion(held, images, 1e-10, 10);
    }
}

template <int D>
Problem<D> repeated(const std::string& method, int periods) {
  std::array<bool, D> periodic{};
  periodic[0] = true;
  Problem<D> problem = wavy<D>(method, 6);
  Vector<D> lower = problem.grid.lower(), upper;
  for (int d = 0; d < D; ++d) upper[d] = problem.grid.upper(d);
  lower[0] = 0.6;
  upper[0] = 0.6 + 0.6 * periods;
  problem.grid = periodic_grid<D>(lower, upper, 0.1, periodic);
  problem.periodic = periodic;
  const Particles<D> one = problem.particles;
  for (int n = 1; n < periods; ++n)
    for (std::size_t p = 0; p < one.size(); ++p) {
      Vector<D> X = one.X[p];
      X[0] += 0.6 * n;
      problem.particles.add(X, one.half_edges[p], 1000, 0);
      problem.particles.v.back() = one.v[p];
    }
  return problem;
}

// Two periods are one of twice the length, for every method.
TEST(Periods, AreOneOfTwiceTheLength) {
  for (const Method& method : methods()) {
    // Least squares of stresses at a free surface are near to singular and enlarge rounding.
    const double rounding = method.quadrature == Quadrature::gauss_cells ? 1e-6 : 1e-9;
    expect_same_motion(repeated<2>(method.name, 1), repeated<2>(method.name, 2), rounding, 10);
  }
}

// Whole cells along, around the end of the period, nothing changes.
TEST(Periods, DoNotKnowWhereTheyBegin) {
  for (const char* method : {"mpm", "cpdi2", "impm", "bspline3", "cpls", "affine_cpdi", "sgmp"}) {
    const Problem<2> here = repeated<2>(method, 1);
    Problem<2> there = here;
    for (std::size_t p = 0; p < there.particles.size(); ++p)
      for (auto* place : {&there.particles.X[p], &there.particles.x[p]}) {
        (*place)[0] += 0.3;
        if ((*place)[0] > 1.2) (*place)[0] -= 0.6;
      }
    expect_same_motion(here, there, 1e-9, 10);
  }
}

// Nodes have the mass and the momentum of the particles, counted once. Momentum stays as it does
// without periods: to rounding, but for nodes that are too light to feel forces, and for masses of
// cells, which are not those of the particles.
TEST(Periods, KeepMassAndMomentum) {
  for (const Method& method : methods()) {
    if (!method.keeps_momentum() || method.basis == Basis::q8) continue;
    const auto change = [&](const Problem<2>& problem) {
      Simulation<2> simulation(problem);
      simulation.map();
      const Ledger before = account(simulation);
      if (!is_cell(method.quadrature) && !is_gauss(method.quadrature)) {
        EXPECT_NEAR(before.node_mass, before.mass, 1e-12 * before.mass) << method.name;
      }
      const double scale = before.mass * 0.15;
      EXPECT_NEAR(before.node_momentum[0], before.momentum[0], 1e-12 * scale) << method.name;
      for (int i = 0; i < 20; ++i) simulation.step(0.01);
      simulation.map();
      return std::abs(account(simulation, before).momentum[0] - before.momentum[0]) / scale;
    };
    const double free = change(wavy<2>(method.name, 6));
    EXPECT_LE(change(repeated<2>(method.name, 1)), std::max(1e-11, 10 * free)) << method.name;
  }
}

// A body that fills its period flies through it three times: velocity, momentum and energy stay to
// rounding, and the displacement is v t.
TEST(Periods, AreFlownThroughThreeTimes) {
  for (const char* method : {"mpm", "ugimp", "cpdi1", "cpdi2", "bspline2", "bspline3", "sgmp",
                             "impm", "cpls", "improved_cpdi", "affine_cpdi"}) {
    Problem<1> problem = repeated<1>(method, 1);
    for (auto& v : problem.particles.v) v[0] = 0.9;
    Simulation<1> simulation(problem);
    simulation.map();
    const Ledger before = account(simulation);
    for (int i = 0; i < 200; ++i) simulation.step(0.01);  // 1.8, three times the period
    simulation.map();
    const Ledger after = account(simulation, before);
    EXPECT_NEAR(after.momentum[0], before.momentum[0], 1e-11 * before.momentum[0]) << method;
    EXPECT_NEAR(after.total(), before.total(), 1e-11 * before.total()) << method;
    EXPECT_NEAR(after.node_kinetic, before.kinetic, 1e-9 * before.kinetic) << method;
    for (std::size_t p = 0; p < problem.particles.size(); ++p) {
      const double x = simulation.particles().x[p][0];
      EXPECT_TRUE(x >= 0.6 - 1e-12 && x <= 1.2 + 1e-12) << method << " " << x;
      EXPECT_NEAR(x - simulation.particles().X[p][0], 1.8, 1e-11) << method;
    }
  }
}

// Corners beyond the grid follow its outermost cells as these go on: in a linear field, which the
// fit of improved_cpdi has at all nodes, exactly.
TEST(CornersOfDomains, FollowTheGridBeyondItsFaces) {
  Problem<2> problem = block<2>(4, 0, 1, "improved_cpdi");
  Matrix<2> slope;
  slope << 0.5, -1, 0.25, 2;
  const auto velocity_at = [&](const Vector<2>& x) {
    return Vector<2>(Vector<2>(1, -2) + slope * x);
  };
  for (std::size_t p = 0; p < problem.particles.size(); ++p)
    problem.particles.v[p] = velocity_at(problem.particles.x[p]);
  State<2> state = start(problem);
  const std::size_t last = state.particles.size() - 1;
  state.particles.corners[last][3] += Vector<2>(0.03, 0.02);
  const auto before = state.particles.corners[last];
  const double dt = 1e-4;
  Step<2> step(problem);
  step(state, dt);
  for (std::size_t a = 0; a < 4; ++a)
    EXPECT_LE((state.particles.corners[last][a] - before[a] - dt * velocity_at(before[a])).norm(),
              1e-13);
}

template <int D>
std::string refusal(const Problem<D>& problem) {
  try {
    problem.validate();
  } catch (const InvalidArgument& error) {
    return error.what();
  }
  return "";
}

TEST(ImagesOfParticles, RefuseWhatTheyCannotBe) {
  const auto expect = [](const Problem<2>& problem, const std::string& text) {
    EXPECT_NE(refusal(problem).find(text), std::string::npos) << refusal(problem);
  };
  Problem<2> problem = wavy<2>("cpdi1", 5.37, 18);
  problem.boundaries = {wall<2>(0, 0.537, false, true)};
  EXPECT_EQ(refusal(problem), "");
  Problem<2> other = problem;
  other.boundaries[0].at = 0.337;
  expect(other, "leave four cells of the grid beyond it");
  other = problem;
  other.boundaries[0].at = 0.9;
  expect(other, "nearer to one face");
  other = problem;
  other.boundaries[0].from = {0, 0};
  expect(other, "the whole plane has images");
  other = problem;
  other.boundaries[0].velocity[0] = 0.5;
  expect(other, "must be zero along its axis");
  other = problem;
  other.boundaries.push_back(wall<2>(0, 0.54, false, true));
  expect(other, "the only one at this end");
  other = problem;
  other.boundaries[0].at = 0.637;
  expect(other, "beyond a boundary with images by more than half a cell");
  other = problem;
  other.method = composed("cpdi1+mass=consistent");
  expect(other, "must be lumped");
  other.method = composed("polypic");
  expect(other, "affine and all others can");
  other.method = composed("impm");
  EXPECT_EQ(refusal(other), "");
  other.boundaries[0] = wall<2>(0, 0.537, true, true);
  expect(other, "a roller can");

  other = repeated<2>("cpdi1", 1);
  EXPECT_EQ(refusal(other), "");
  other.boundaries = {wall<2>(0, 0.6, false, false)};
  expect(other, "must not be periodic");
  other = repeated<2>("cpdi1", 1);
  other.particles.x[3][0] = 0.5;
  expect(other, "must lie in the period");
  other = repeated<2>("cpdi1", 1);
  other.grid = Grid<2>({0.2, 0}, {1.0, 1.6}, 0.1);
  expect(other, "more than the eight beyond the ends of a period");
}

// A particle that goes through a wall with images is told of.
TEST(ImagesOfParticles, AreNoWayThroughAWall) {
  Problem<1> problem = wavy<1>("mpm", 5.37, 18);
  problem.boundaries = {wall<1>(0, 0.537, false, true)};
  for (auto& v : problem.particles.v) v[0] = -20;
  State<1> state = start(problem);
  Step<1> step(problem);
  EXPECT_THROW(
      {
        for (int i = 0; i < 50; ++i) step(state, 0.01);
      },
      Failure);
}

}  // namespace
}  // namespace recon::mpm::test
