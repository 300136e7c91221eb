// Materials: stress is the slope of energy, rigid turns change nothing, small strains are linear.
#include "recon/mpm/material.hpp"

#include <cmath>

#include "mpm/support.hpp"

namespace recon::mpm::test {
namespace {

template <class T>
class Materials : public testing::Test {};
TYPED_TEST_SUITE(Materials, AllDimensions);

// J sigma = (dW/dF) F^T.
TYPED_TEST(Materials, NeoHookeanStressIsTheSlopeOfItsEnergy) {
  constexpr int D = TypeParam::value;
  const NeoHookean material{Lame::from(100, 0.3)};
  std::mt19937 random(2);
  for (int round = 0; round < 20; ++round) {
    const Matrix<D> F = random_deformation<D>(random, 0.3), none = Matrix<D>::Zero();
    Matrix<D> stress, ignored, slope;
    double energy = 0, up = 0, down = 0;
    material.update(F, none, 0, stress, energy);
    EXPECT_GE(energy, 0);
    const double step = 1e-5;
    for (int i = 0; i < D; ++i)
      for (int j = 0; j < D; ++j) {
        Matrix<D> change = none;
        change(i, j) = step;
        material.update(Matrix<D>(F + change), none, 0, ignored, up);
        material.update(Matrix<D>(F - change), none, 0, ignored, down);
        slope(i, j) = (up - down) / (2 * step);
      }
    EXPECT_LE((stress * F.determinant() - slope * F.transpose()).norm(), 1e-6 * material.mu);
  }
}

// Beyond the yield stress: strained along one axis the difference of the principal stresses is the
// yield stress and what hardening adds, while the mean stress goes on elastically; below it, and on
// the way back, all is as in LinearElastic.
TYPED_TEST(Materials, VonMisesYields) {
  constexpr int D = TypeParam::value;
  const Lame elastic = Lame::from(100, 0.25);
  for (const double hardening : {0.0, 30.0}) {
    VonMises material{elastic};
    material.yield = 0.1;
    material.hardening = hardening;
    Matrix<D> rate = Matrix<D>::Zero(), stress = Matrix<D>::Zero(), plain = Matrix<D>::Zero();
    rate(0, 0) = 1;
    double energy = 0, ignored = 0, remembered[2] = {0, 0};
    const Matrix<D> F = Matrix<D>::Identity();
    const double dt = 1e-5, start = 0.1 / (2 * elastic.mu);  // the strain at which it yields
    double strain = 0;
    const auto across = [&] { return D == 1 ? remembered[1] : stress(D - 1, D - 1); };
    for (; strain < 4 * start; strain += dt) {
      material.update(F, rate, dt, stress, energy, remembered);
      LinearElastic{elastic}.update(F, rate, dt, plain, ignored);
      const double mean = (stress(0, 0) + 2 * across()) / 3;
      EXPECT_NEAR(mean, (elastic.lambda + 2 * elastic.mu / 3) * (strain + dt), 1e-10);
      if (strain + dt < start) {
        EXPECT_LE((stress - plain).norm(), 1e-12);
      } else {
        EXPECT_NEAR(stress(0, 0) - across(), 0.1 + hardening * remembered[0], 1e-10);
      }
      EXPECT_NEAR(material.out_of_plane(F, stress, remembered), D == 3 ? remembered[1] : across(),
                  1e-12);
    }
    // The plastic strain along the axis is the equivalent one, minus half of it that across.
    EXPECT_NEAR(remembered[0], (2 * elastic.mu * strain - 0.1) / (3 * elastic.mu + hardening),
                1e-10);
    const Matrix<D> loaded = stress;
    const double plastic = remembered[0];
    material.update(F, Matrix<D>(-rate), dt, stress, energy, remembered);
    LinearElastic{elastic}.update(F, Matrix<D>(-rate), dt, plain = loaded, ignored);
    EXPECT_LE((stress - plain).norm(), 1e-12);
    EXPECT_EQ(remembered[0], plastic);
  }
  VonMises bad{elastic};
  EXPECT_THROW(bad.validate(), InvalidArgument);
  bad.yield = 1;
  EXPECT_NO_THROW(bad.validate());
  bad.hardening = -1;
  EXPECT_THROW(bad.validate(), InvalidArgument);
}

// A strain of 1e-6 in a hundred steps: sigma = lambda tr(e) I + 2 mu e in both.
TYPED_TEST(Materials, SmallStrainIsHookes) {
  constexpr int D = TypeParam::value;
  const Lame elastic = Lame::from(100, 0.25);
  std::mt19937 random(4);
  const Matrix<D> rate = random_deformation<D>(random, 1) - Matrix<D>::Identity();
  const Matrix<D> e = 1e-6 * (rate + rate.transpose()) / 2;
  const Matrix<D> expected =
      elastic.lambda * e.trace() * Matrix<D>::Identity() + 2 * elastic.mu * e;
  Matrix<D> F = Matrix<D>::Identity(), hypo = Matrix<D>::Zero(), hyper;
  double hypo_energy = 0, hyper_energy = 0;
  for (int step = 0; step < 100; ++step) {
    F += 1e-8 * rate * F;
    LinearElastic{elastic}.update(F, rate, 1e-8, hypo, hypo_energy);
  }
  NeoHookean{elastic}.update(F, rate, 0, hyper, hyper_energy);
  EXPECT_LE((hypo - expected).norm(), 1e-4 * expected.norm());
  EXPECT_LE((hyper - expected).norm(), 1e-4 * expected.norm());
  EXPECT_NEAR(hypo_energy, expected.cwiseProduct(e).sum() / 2, 1e-4 * hypo_energy);
  EXPECT_NEAR(hyper_energy, hypo_energy, 1e-3 * hypo_energy);
}

// Pulled to F = a I the stress is (D lambda + 2 mu) ln a, and its work per reference volume the
// integral of a^D tr(sigma) da / a: J counts.
TYPED_TEST(Materials, EnergyIsTheWorkPerReferenceVolume) {
  constexpr int D = TypeParam::value;
  const LinearElastic material{Lame::from(100, 0.3)};
  const double modulus = D * material.lambda + 2 * material.mu;
  for (const double a : {0.6, 1.5}) {
    const int steps = 1000;
    const Matrix<D> rate = std::log(a) * Matrix<D>::Identity();
    Matrix<D> stress = Matrix<D>::Zero();
    double energy = 0;
    for (int step = 1; step <= steps; ++step)
      material.update(Matrix<D>(std::pow(a, double(step) / steps) * Matrix<D>::Identity()), rate,
                      1.0 / steps, stress, energy);
    EXPECT_LE((stress - modulus * rate).norm(), 1e-10 * stress.norm());
    const double J = std::pow(a, D), work = modulus * (J * std::log(a) - (J - 1) / D);
    EXPECT_NEAR(energy, work, 3.0 * D / steps * work);  // J is that after the step: first order
  }
}

// Stress of small_strain is the slope of its energy in the strain and linear in it; a turn strains
// it, as linear theory has it, and any shift of F that is skew does not.
TYPED_TEST(Materials, HookesLawIsLinearInTheGradient) {
  constexpr int D = TypeParam::value;
  const SmallStrain material{Lame::from(100, 0.3)};
  std::mt19937 random(8);
  const auto at = [&](const Matrix<D>& H) {
    std::pair<Matrix<D>, double> found{Matrix<D>::Zero(), 0};
    material.update(Matrix<D>(Matrix<D>::Identity() + H), Matrix<D>(Matrix<D>::Zero()), 1.0,
                    found.first, found.second);
    return found;
  };
  for (int round = 0; round < 20; ++round) {
    const Matrix<D> H = random_deformation<D>(random, 0.4) - Matrix<D>::Identity();
    const Matrix<D> G = random_deformation<D>(random, 0.4) - Matrix<D>::Identity();
    const auto [stress, energy] = at(H);
    EXPECT_LE((at(H + G).first - stress - at(G).first).norm(), 1e-12 * material.mu);
    EXPECT_LE((at(H - H.transpose()).first).norm(), 1e-12 * material.mu);
    EXPECT_NEAR(energy, stress.cwiseProduct(H).sum() / 2, 1e-12 * material.mu);
    EXPECT_LE((stress - stress.transpose()).norm(), 1e-12 * material.mu);
  }
  if constexpr (D > 1) {
    Matrix<D> turn = Matrix<D>::Identity();
    turn(0, 0) = turn(1, 1) = std::cos(0.1);
    turn(1, 0) = std::sin(0.1);
    turn(0, 1) = -turn(1, 0);
    const auto [stress, energy] = at(turn - Matrix<D>::Identity());
    const double strain = std::cos(0.1) - 1;
    EXPECT_NEAR(stress(0, 0), 2 * (material.lambda + material.mu) * strain, 1e-12);
    EXPECT_GT(energy, 0);
  }
}

// A body that does not strain along z: what is said of sigma_zz is what the same
// material has in 3-D.
TYPED_TEST(Materials, StressOutOfPlaneIsThatOfThreeDimensions) {
  constexpr int D = TypeParam::value;
  if constexpr (D < 3) {
    const Lame elastic = Lame::from(100, 0.3);
    std::mt19937 random(6);
    const auto embedded = [](const Matrix<D>& A, double rest) {
      Matrix<3> all = rest * Matrix<3>::Identity();
      all.template topLeftCorner<D, D>() = A;
      return all;
    };
    for (int round = 0; round < 20; ++round) {
      const auto check = [&](const auto& material) {
        Matrix<D> F = Matrix<D>::Identity(), stress = Matrix<D>::Zero();
        Matrix<3> solid = Matrix<3>::Zero();
        double energy = 0;
        for (int step = 0; step < 5; ++step) {
          const Matrix<D> L = random_deformation<D>(random, 1) - Matrix<D>::Identity();
          F += 0.05 * L * F;
          material.update(F, L, 0.05, stress, energy);
          material.update(embedded(F, 1), embedded(L, 0), 0.05, solid, energy);
        }
        EXPECT_LE((solid.template topLeftCorner<D, D>() - stress).norm(), 1e-10 * elastic.mu);
        EXPECT_NEAR(material.out_of_plane(F, stress), solid(2, 2), 1e-10 * elastic.mu);
      };
      check(NeoHookean{elastic});
      check(SmallStrain{elastic});
      check(LinearElastic{elastic});
    }
  }
}

// A stressed material that turns: the stress turns with it, the energy stays.
TEST(LinearElasticMaterial, RigidTurn) {
  const LinearElastic material{Lame::from(100, 0.25)};
  Matrix<2> stress, spin;
  stress << 3, 1, 1, -2;
  spin << 0, -1, 1, 0;
  const Matrix<2> before = stress;
  double energy = 0.5;
  const int steps = 20000;
  const double angle = 0.7;
  for (int s = 0; s < steps; ++s)
    material.update(Matrix<2>(Matrix<2>::Identity()), spin, angle / steps, stress, energy);
  Matrix<2> turn;
  turn << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  EXPECT_LE((stress - turn * before * turn.transpose()).norm(), 1e-3);
  EXPECT_NEAR(energy, 0.5, 1e-12);
}

TEST(LameConstants, SpeedsAndRanges) {
  const Lame steel = Lame::from(1e7, 0.3);
  EXPECT_NEAR(steel.bar_wave_speed(1000), 100, 1e-10);
  EXPECT_NEAR(steel.p_wave_speed(1000), 100 * std::sqrt(0.7 / (1.3 * 0.4)), 1e-10);
  EXPECT_THROW(Lame::from(0, 0.3), InvalidArgument);
  EXPECT_THROW(Lame::from(1, 0.5), InvalidArgument);
  EXPECT_THROW(Lame::from(1, -1), InvalidArgument);
  EXPECT_THROW(Lame::from(std::nan(""), 0.3), InvalidArgument);
  // Given themselves: a pull on all sides must need work.
  EXPECT_NO_THROW((Lame{-0.66, 1}.validate()));
  EXPECT_THROW((Lame{-0.67, 1}.validate()), InvalidArgument);
  EXPECT_THROW((Lame{1, 0}.validate()), InvalidArgument);
}

}  // namespace
}  // namespace recon::mpm::test
