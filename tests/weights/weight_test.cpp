#include "recon/weights/weight.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "recon/core/error.hpp"
#include "support/message_of.hpp"

namespace recon {
namespace {

static_assert(std::is_copy_constructible_v<WeightFunction> &&
              std::is_copy_assignable_v<WeightFunction>);

struct Evaluated {
  double value, slope;
};

Evaluated evaluate(const WeightFunction& weight, double q) {
  Evaluated result;
  weight.evaluate(&q, &result.value, &result.slope, 1);
  return result;
}

TEST(Weights, PositiveInsideZeroOutsideFalling) {
  for (const Weight kind : all_weights()) {
    const WeightFunction weight(kind);
    double before = evaluate(weight, 0).value;
    for (double q = 0.001; q < 1; q += 0.001) {
      const double w = evaluate(weight, q).value;
      EXPECT_GT(w, 0) << name_of(kind) << " at " << q;
      EXPECT_LE(w, before) << name_of(kind) << " at " << q;
      before = w;
    }
    for (const double q : {1.0, 1.5, 100.0}) {
      EXPECT_EQ(evaluate(weight, q).value, 0) << name_of(kind);
      EXPECT_EQ(evaluate(weight, q).slope, 0) << name_of(kind);
    }
    EXPECT_LT(evaluate(weight, 1 - 1e-9).value, 1e-8) << name_of(kind) << " is continuous at q = 1";
  }
}

TEST(Weights, SlopesAreDerivatives) {
  for (const Weight kind : all_weights()) {
    const WeightFunction weight(kind);
    const double h = 1e-6;
    for (double q = 0.00312; q < 0.999; q += 0.0123) {
      const double difference =
          (evaluate(weight, q + h).value - evaluate(weight, q - h).value) / (2 * h);
      const double slope = evaluate(weight, q).slope;
      EXPECT_NEAR(slope, difference, 1e-7 * (1 + std::abs(slope))) << name_of(kind) << " at " << q;
    }
  }
}

// On a grid of spacing h, support (P + 1) h / 2, the cardinal splines sum to one everywhere.
template <int P>
void check_partition_of_unity() {
  const double rho = (P + 1) / 2.0;
  for (double x = 0; x < 1; x += 0.0371) {
    double sum = 0, slope = 0;
    for (int i = -5; i <= 6; ++i) {
      const double q = std::abs(x - i) / rho;
      if (q >= 1) continue;
      sum += BSpline<P>{}(q);
      slope += BSpline<P>{}.derivative(q) * (x > i ? 1 : -1);
    }
    EXPECT_NEAR(sum, 1, 1e-14) << "degree " << P << " at " << x;
    if (x > 0) {
      EXPECT_NEAR(slope, 0, 1e-13) << "degree " << P << " at " << x;
    }
  }
}

TEST(BSplines, SumToOneOnAGrid) {
  check_partition_of_unity<1>();
  check_partition_of_unity<2>();
  check_partition_of_unity<3>();
  check_partition_of_unity<4>();
  check_partition_of_unity<5>();
}

// The published pieces: cubic (Tran et al. 2019, eq. 10), quadratic (Gong 2015, eq.
// 5.2), in units of h.
TEST(BSplines, EqualThePublishedPieces) {
  for (double x = 0; x < 2; x += 0.01) {
    const double cubic =
        x < 1 ? 2.0 / 3 - x * x + x * x * x / 2 : 4.0 / 3 - 2 * x + x * x - x * x * x / 6;
    EXPECT_NEAR(BSpline<3>{}(x / 2), cubic, 1e-15);
  }
  for (double x = 0; x < 1.5; x += 0.01) {
    const double quadratic = x < 0.5 ? 0.75 - x * x : (1.5 - x) * (1.5 - x) / 2;
    EXPECT_NEAR(BSpline<2>{}(x / 1.5), quadratic, 1e-15);
  }
  for (double x = 0; x < 1; x += 0.01) EXPECT_NEAR(BSpline<1>{}(x), 1 - x, 1e-16);
}

// (exp(-a q^2) - exp(-a)) / (1 - exp(-a)), which is 1 - q^2 for a = 1 / c^2 -> 0.
TEST(Gaussian, EqualsItsFormulaAndItsLimit) {
  for (double q = 0; q < 1; q += 0.0173) {
    for (const double shape : {0.2, 0.4, 1.0, 3.0}) {
      const long double a = 1 / (static_cast<long double>(shape) * shape);
      const long double end = std::exp(-a);
      const double wanted = static_cast<double>((std::exp(-a * q * q) - end) / (1 - end));
      EXPECT_NEAR(evaluate(Gaussian{shape}, q).value, wanted, 1e-15 + 4e-15 * wanted) << shape;
    }
    for (const double shape : {1e9, 1e100, 1e200}) {
      EXPECT_NEAR(evaluate(Gaussian{shape}, q).value, 1 - q * q, 4e-16) << shape;
      EXPECT_NEAR(evaluate(Gaussian{shape}, q).slope, -2 * q, 8e-16) << shape;
      const auto x = static_cast<float>(q);
      EXPECT_NEAR(Gaussian{shape}(x), 1 - x * x, 3e-7f) << shape;
    }
    // The other limit: nothing but what lies on the target.
    EXPECT_EQ(evaluate(Gaussian{1e-200}, q).value, q == 0 ? 1 : 0);
  }
}

TEST(Weights, BadParametersAreNamed) {
  using ::testing::HasSubstr;
  for (const double bad : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
    EXPECT_THAT(testing::message_of([&] { WeightFunction{Gaussian{bad}}; }),
                HasSubstr("shape of the weight Gaussian = "));
    EXPECT_THAT(testing::message_of([&] { WeightFunction{InverseDistance{bad}}; }),
                HasSubstr("softening of the weight InverseDistance = "));
  }
}

TEST(Weights, BadValuesAreNamed) {
  struct Broken {
    double value, slope;
    double operator()(double q) const { return q < 0.5 ? 1 : value; }
    double derivative(double q) const { return q < 0.5 ? 0 : slope; }
  };
  using ::testing::HasSubstr;
  const std::vector<double> q{0.25, 0.75, 1.5};
  std::vector<double> w(3), slope(3);
  const auto said = [&](const Broken& weight) {
    return testing::message_of(
        [&] { WeightFunction(weight).evaluate(q.data(), w.data(), slope.data(), q.size()); });
  };
  EXPECT_THAT(said({1, 0}), HasSubstr("no InvalidArgument"));
  for (const double bad : {-1.0, std::nan(""), HUGE_VAL}) {
    EXPECT_THAT(said({bad, 0}), HasSubstr("weight w(q) at q = 0.75 = "));
    EXPECT_THAT(said({bad, 0}), HasSubstr("must be finite and not negative"));
  }
  EXPECT_THAT(said({1, HUGE_VAL}), HasSubstr("derivative w'(q) of the weight at q = 0.75 = inf"));
}

TEST(Weights, NamesGoBothWays) {
  for (const Weight kind : all_weights()) EXPECT_EQ(weight_named(name_of(kind)), kind);
  try {
    weight_named("wendland_c3");
    FAIL();
  } catch (const InvalidArgument& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("wendland_c3"));
    EXPECT_THAT(error.what(), ::testing::HasSubstr("'wendland_c2'"));
  }
}

TEST(Weights, OwnWeightInFloatAndDouble) {
  struct Hat {
    double operator()(double q) const { return 1 - q; }
    double derivative(double) const { return -1; }
  };
  const WeightFunction own(Hat{});
  EXPECT_EQ(evaluate(own, 0.25).value, 0.75);
  EXPECT_EQ(evaluate(own, 0.25).slope, -1);
  EXPECT_EQ(evaluate(own, 1).value, 0);  // never called outside [0, 1)
  const float q = 0.5f;
  float w;
  own.evaluate(&q, &w, nullptr, 1);
  EXPECT_EQ(w, 0.5f);
}

}  // namespace
}  // namespace recon
