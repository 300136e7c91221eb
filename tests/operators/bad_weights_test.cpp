// Weights that are no weights: errors with q and w out of every path, from any thread; and none
// from places where no particle is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "recon/neighbourhood/kd_tree.hpp"
#include "recon/points/generate.hpp"
#include "recon/recon.hpp"
#include "recon/shape/shape_function.hpp"
#include "support/message_of.hpp"
#include "support/typed.hpp"

namespace recon::testing {
namespace {

using ::testing::HasSubstr;

// 1 - q, but `value` for q > 1/2.
struct Broken {
  double value, slope = -1;
  double operator()(double q) const { return q > 0.5 ? value : 1 - q; }
  double derivative(double q) const { return q > 0.5 ? slope : -1; }
};

template <class C>
class BadWeights : public ::testing::Test {};
TYPED_TEST_SUITE(BadWeights, AllCases, CaseNames);

TYPED_TEST(BadWeights, AreErrorsWithQAndW) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = random_points<Scalar, D>(300, 3);
  Options options{.neighbours = Radius{0.4}};
  const auto said = [&] {
    return message_of(
        [&] { BasicReconstruction<Scalar>(points_of(points), points_of(points), options); });
  };
  for (const InstructionSet set : available_instruction_sets())
    for (const Solver solver : {Solver::moment_matrix, Solver::qr})
      for (const int threads : {1, 4}) {
        options.instruction_set = set;
        options.solver = solver;
        options.threads = threads;
        for (const double bad : {-1e-3, std::nan(""), HUGE_VAL}) {
          options.weight = Broken{bad};
          EXPECT_THAT(said(), HasSubstr("weight w(q) at q = 0."));
          EXPECT_THAT(said(), HasSubstr("must be finite and not negative"));
        }
        // Slopes are asked for by exact gradients only.
        options.weight = Broken{0.5, std::nan("")};
        EXPECT_THAT(said(), HasSubstr("no InvalidArgument"));
        const BasicReconstruction<Scalar> fit(points_of(points), points_of(points), options);
        EXPECT_THAT(message_of([&] { fit.gradient(); }),
                    HasSubstr("derivative w'(q) of the weight at q = 0."));
        EXPECT_THAT(message_of([&] { fit.gradient(Derivative::diffuse); }),
                    HasSubstr("no InvalidArgument"));
      }
}

TYPED_TEST(BadWeights, AreErrorsAtOnePoint) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = random_points<Scalar, D>(300, 3);
  const PointCloud<Scalar> cloud(points_of(points));
  const KdTree<Scalar, D> search(cloud);
  std::array<Scalar, D> x;
  x.fill(Scalar(0.5));
  const auto position = [&](ParticleIndex p) { return points[p]; };
  for (const double bad : {-1e-3, std::nan(""), HUGE_VAL}) {
    ShapeEvaluator<Monomials<D, 1>, Broken, Scalar> shapes(Broken{bad});
    EXPECT_THAT(message_of([&] { shapes.at(x, Scalar(0.4), search, position); }),
                HasSubstr("weight w(q) at q = 0."));
  }
  ShapeEvaluator<Monomials<D, 1>, Broken, Scalar> shapes(Broken{0.5, HUGE_VAL});
  EXPECT_THAT(message_of([&] { shapes.at(x, Scalar(0.4), search, position); }),
              HasSubstr("derivative w'(q) of the weight at q = 0."));
  EXPECT_THAT(message_of([&] { (ShapeEvaluator<Monomials<D, 1>, Gaussian, Scalar>(Gaussian{0})); }),
              HasSubstr("shape of the weight Gaussian = 0"));
}

// A weight that interpolates has no value at q = 0. That is no error as long as no particle lies
// there, whatever else stands in the lanes.
struct Singular {
  double operator()(double q) const { return (1 - q) / q; }
  double derivative(double q) const { return -1 / (q * q); }
};

TYPED_TEST(BadWeights, AreAskedForParticlesOnly) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = random_points<Scalar, D>(300, 3);
  auto targets = random_points<Scalar, D>(61, 4);
  for (const InstructionSet set : available_instruction_sets())
    for (const WeightForm form : {WeightForm::radial, WeightForm::tensor_product})
      for (const Solver solver : {Solver::moment_matrix, Solver::gram_schmidt}) {
        Options options{
            .weight = Singular{}, .form = form, .neighbours = Radius{0.3}, .solver = solver};
        options.instruction_set = set;
        const BasicReconstruction<Scalar> fit(points_of(points), points_of(targets), options);
        EXPECT_NO_THROW(fit.gradient());
      }
  targets[5] = points[17];
  EXPECT_THAT(message_of([&] {
                BasicReconstruction<Scalar>(points_of(points), points_of(targets),
                                            {.weight = Singular{}, .neighbours = Radius{0.3}});
              }),
              HasSubstr("weight w(q) at q = 0 = inf"));
}

// Factors that are numbers, with a product that is none.
TEST(BadWeightProducts, AreErrors) {
  struct Large {
    double operator()(double) const { return 1e200; }
    double derivative(double) const { return 0; }
  };
  const auto points = random_points<double, 2>(300, 3);
  EXPECT_THAT(
      message_of([&] {
        reconstruct(
            points_of(points), points_of(points),
            {.weight = Large{}, .form = WeightForm::tensor_product, .neighbours = Radius{0.3}});
      }),
      HasSubstr("largest product of weights at a target = inf"));
}

}  // namespace
}  // namespace recon::testing
