// A bar of a von Mises material that a moving boundary pulls far beyond yield, against the closed
// form of uniaxial strain. With e = ln F, all of it elastic up to e_y = yield / (2 mu):
//     sigma = (lambda + 2 mu) e                              e <= e_y
//     d sigma / d e = lambda + 2 mu - 4 mu^2 / (3 mu + H)    beyond
//     plastic strain = 2 mu (e - e_y) / (3 mu + H) ,   Mises stress = yield + H plastic strain
// for the Mises stress |sigma - sigma_beside| rises by 2 mu de, of which flow takes 3 mu dp.
// Unloading has the elastic slope until the Mises stress is that of yield on the other side.
#include <cmath>

#include "mpm/support.hpp"

namespace recon::mpm::test {
namespace {

constexpr double length = 10, speed = 1.25e-3, plane = 10;

VonMises soft_metal() {
  VonMises metal{Lame::from(1, 0.3), 0, 0};
  metal.yield = 0.01 * metal.mu;
  metal.hardening = 0.3 * metal.mu;
  return metal;
}

// The bar goes on beyond the plane that is moved, so that no end of it is drawn through the cells.
// All of it starts with the velocities of the uniform strain, and so without waves.
Problem<1> bar(const std::string& method, double sign) {
  const VonMises metal = soft_metal();
  const double c = metal.p_wave_speed(1);
  Problem<1> problem;
  problem.grid = Grid<1>(Vector<1>(0), Vector<1>(length + 4), 1);
  problem.materials = {metal};
  problem.densities = {1};
  problem.method = method_named(method);
  for (double X = 0.25; X < length + 2; X += 0.5) {
    problem.particles.add(Vector<1>(X), Matrix<1>(0.25), 1, 0);
    problem.particles.v.back()[0] = sign * speed * c * std::min(X / plane, 1.0);
    problem.particles.L.back()(0, 0) = X < plane ? sign * speed * c / plane : 0;
  }
  problem.boundaries = {{0, 0, {0.0}}, {0, plane, {sign * speed * c}}};
  problem.time.rule = StepRule::fixed;
  problem.time.step = 0.4 / c;
  return problem;
}

class PlasticBar : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Mpm, PlasticBar,
                         testing::Values("cpdi1", "cpdi2", "cpgimp", "cpls", "improved_cpdi"),
                         [](const auto& each) { return std::string(each.param); });

TEST_P(PlasticBar, FollowsTheClosedForm) {
  const VonMises metal = soft_metal();
  const double modulus = metal.lambda + 2 * metal.mu, first = metal.yield / (2 * metal.mu);
  const double tangent = modulus - 4 * metal.mu * metal.mu / (3 * metal.mu + metal.hardening);
  Simulation<1> pulled(bar(GetParam(), 1));
  constexpr int steps = 1000;
  const double dt = pulled.problem().time.step;
  const auto strain_of = [](const Particles<1>& all, std::size_t p) {
    return std::log(all.F[p](0, 0));
  };
  double largest = 0;
  for (int s = 1; s <= steps; ++s) {
    pulled.step(dt);
    const double e = speed * metal.p_wave_speed(1) / plane * dt * s;
    for (const std::size_t p : {0u, 5u, 10u}) {
      const Particles<1>& all = pulled.particles();
      const double by_particle = strain_of(all, p);
      // The plane cuts one of the twenty particles, which is softer than the others.
      ASSERT_NEAR(by_particle, e, 0.05 * e) << "step " << s << ", particle " << p;
      const double stress = by_particle < first ? modulus * by_particle
                                                : modulus * first + tangent * (by_particle - first);
      ASSERT_NEAR(all.stress[p](0, 0), stress, 1e-3 * stress) << s;
      const double plastic =
          std::max(0.0, by_particle - first) * 2 * metal.mu / (3 * metal.mu + metal.hardening);
      const double mises = all.stress[p](0, 0) - all.history[2 * p + 1];
      ASSERT_NEAR(all.history[2 * p], plastic, 1e-3 * (first + plastic)) << s;
      if (plastic > 0) {
        ASSERT_NEAR(mises, metal.yield + metal.hardening * plastic, 1e-3 * metal.yield) << s;
      }
      largest = std::max(largest, by_particle);
    }
  }
  EXPECT_GT(largest, 9 * first);  // far beyond

  // Back, for less than the elastic range on the other side, 2 (yield + H p) / (2 mu).
  Simulation<1> back(bar(GetParam(), -1));
  State<1> state = pulled.state();
  for (auto& v : state.particles.v) v = -v;
  for (auto& L : state.particles.L) L = -L;
  for (auto& m : state.particles.modes) m = -m;
  back.restore(state);
  const Particles<1> top = state.particles;
  for (int s = 1; s <= 100; ++s) {
    back.step(dt);
    for (const std::size_t p : {0u, 5u}) {
      const Particles<1>& all = back.particles();
      const double fallen = strain_of(top, p) - strain_of(all, p);
      ASSERT_NEAR(top.stress[p](0, 0) - all.stress[p](0, 0), modulus * fallen,
                  1e-3 * modulus * fallen + 1e-12);
      ASSERT_EQ(all.history[2 * p], top.history[2 * p]);  // no flow
    }
  }
  EXPECT_GT(strain_of(top, 0) - strain_of(back.particles(), 0), 0.8 * 0.005);
}

}  // namespace
}  // namespace recon::mpm::test
