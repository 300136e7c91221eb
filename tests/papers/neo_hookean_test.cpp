// The first Piola-Kirchhoff stress of the neo-Hookean material, as Gong (2015, eq. 4.33) and Tran
// et al. (2019, eq. 45) print it and as it must be: the slope of the energy
//     W(F) = lambda (ln J)^2 / 2 + mu (tr F^T F / 2 - ln J),
// by central differences, at deformations that shear and turn.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

namespace recon {
namespace {

using Matrix = Eigen::Matrix3d;
constexpr double lambda = 5.77, mu = 3.85;

double energy(const Matrix& F) {
  const double log_J = std::log(F.determinant());
  return lambda * log_J * log_J / 2 + mu * ((F.transpose() * F).trace() / 2 - log_J);
}

Matrix slope_of_energy(const Matrix& F) {
  Matrix P;
  constexpr double step = 1e-6;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      Matrix up = F, down = F;
      up(i, j) += step;
      down(i, j) -= step;
      P(i, j) = (energy(up) - energy(down)) / (2 * step);
    }
  return P;
}

const Matrix F = (Matrix() << 1.2, 0.4, 0, -0.1, 0.9, 0.2, 0.3, 0, 1.1).finished();
const Matrix I = Matrix::Identity();

TEST(Gong2015Equation433, IsTheSlopeOfItsEnergy) {
  const double log_J = std::log(F.determinant());
  const auto P = [&](const Matrix& square) {
    return Matrix((lambda * log_J * I + mu * (square - I)) * F.inverse().transpose());
  };
  EXPECT_LE((P(F * F.transpose()) - slope_of_energy(F)).norm(), 1e-7);
  EXPECT_GT((P(F.transpose() * F) - slope_of_energy(F)).norm(), 0.1 * mu);  // as printed
}

TEST(Tran2019Equation45, IsTheSlopeOfItsEnergy) {
  const double log_J = std::log(F.determinant());
  const Matrix inverse = F.inverse(),
               P = lambda * log_J * inverse.transpose() + mu * (F - inverse.transpose());
  EXPECT_LE((P - slope_of_energy(F)).norm(), 1e-7);
  // As printed: inverses that are not transposed, and from the left.
  const Matrix printed = lambda * log_J * inverse + mu * inverse * (F * F.transpose() - I);
  EXPECT_GT((printed - slope_of_energy(F)).norm(), 0.1 * mu);
  // (46) agrees with the corrected form only.
  const double J = F.determinant();
  const Matrix sigma = lambda * log_J / J * I + mu / J * (F * F.transpose() - I);
  EXPECT_LE((P * F.transpose() / J - sigma).norm(), 1e-13);
  EXPECT_GT((printed * F.transpose() / J - sigma).norm(), 0.1 * mu);
}

}  // namespace
}  // namespace recon
