// Summing moments is another way to the same numbers: those of reconstruct().
#include "grid_support.hpp"

namespace recon::testing {
namespace {

template <class C>
class GridEquality : public ::testing::Test {};
TYPED_TEST_SUITE(GridEquality, AllCases, CaseNames);

double natural_support(Weight weight) {
  return weight <= Weight::quintic_b_spline ? (static_cast<int>(weight) + 2) / 2.0 : 1.7;
}

TYPED_TEST(GridEquality, AllWeightsFormsAndDegrees) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = random_points<Scalar, D>(D == 1 ? 60 : D == 2 ? 250 : 500, 5);
  const Matrix<Scalar> u = wave(points, 2);
  const auto grid = uneven_grid<Scalar, D>();
  for (const Weight weight : all_weights())
    for (const WeightForm form : {WeightForm::tensor_product, WeightForm::radial})
      for (int degree = 0; degree <= 2; ++degree) {
        Options options{.degree = degree, .weight = weight, .form = form};
        if (weight > Weight::quintic_b_spline) {
          options.neighbours = Radius{1.7};
          for (int d = 0; d < D; ++d) options.stretch[d] = static_cast<double>(grid.spacing[d]);
        }
        const auto fit = reconstruct_on_grid(points_of(points), {field_of(u)}, grid, options);
        expect_equal(fit, points, u, grid, equivalent(options, grid, natural_support(weight)),
                     std::string(name_of(weight)) + (form == WeightForm::radial ? ", radial" : "") +
                         ", degree " + std::to_string(degree));
        if (this->HasFailure()) return;
      }
}

TYPED_TEST(GridEquality, ManyComponentsAndGradients) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = jittered_points<Scalar, D>(D == 1 ? 60 : D == 2 ? 18 : 9, 0.5, 3);
  const auto grid = cell_centres(uneven_grid<Scalar, D>());
  for (int degree = 0; degree <= 2; ++degree)
    for (const int components : {1, 3, 4, 5, 7, 11}) {
      const Matrix<Scalar> u = wave(points, components);
      const Options options{.degree = degree, .weight = Weight::quadratic_b_spline};
      // The same data as two fields.
      const Matrix<Scalar> first = u.leftCols(1), rest = u.rightCols(components - 1);
      std::vector<FieldView<Scalar>> fields{field_of(first)};
      if (components > 1) fields.push_back(field_of(rest));
      const auto fit = reconstruct_on_grid(points_of(points), fields, grid, options,
                                           {.gradients = Derivative::diffuse});
      const BasicReconstruction<Scalar> expected(points_of(points), grid.nodes().view(),
                                                 equivalent(options, grid, 1.5));
      const std::string where =
          std::to_string(components) + " components, degree " + std::to_string(degree);
      expect_equal(fit, points, u, grid, equivalent(options, grid, 1.5), where);
      const Matrix<Scalar> slopes = expected.gradient(Derivative::diffuse).apply(field_of(u));
      ASSERT_EQ(fit.gradients().cols(), components * D);
      for (Eigen::Index i = 0; i < slopes.rows(); ++i)
        for (Eigen::Index c = 0; c < slopes.cols(); ++c)
          if (fit.report()[i].status != FitStatus::no_support) {
            EXPECT_NEAR(fit.gradients()(i, c), slopes(i, c), 100 * allowed<Scalar>(fit.report()[i]))
                << where << ", node " << i << ", column " << c;
          }
      if (this->HasFailure()) return;
    }
}

TYPED_TEST(GridEquality, HostileClouds) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto grid = uneven_grid<Scalar, D>();
  for (const auto& cloud : hostile_clouds<Scalar, D>())
    for (int degree = 0; degree <= 2; ++degree) {
      const Matrix<Scalar> u = wave(cloud.points, 2);
      const Options options{.degree = degree};
      const auto fit = reconstruct_on_grid(points_of(cloud.points), {field_of(u)}, grid, options);
      expect_equal(fit, cloud.points, u, grid, equivalent(options, grid, 2),
                   cloud.name + ", degree " + std::to_string(degree));
    }
}

// A weight of one's own has no natural support, and is called as it is.
struct Cone {
  template <class T>
  T operator()(T q) const {
    return T(1) - q;
  }
  template <class T>
  T derivative(T) const {
    return T(-1);
  }
};

TYPED_TEST(GridEquality, OwnWeight) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto points = random_points<Scalar, D>(D == 1 ? 60 : 400, 5);
  const Matrix<Scalar> u = wave(points, 1);
  const auto grid = uneven_grid<Scalar, D>();
  Options options{.weight = Cone{}, .neighbours = Radius{1}, .stretch = {0.5, 0.6, 0.7}};
  const auto fit = reconstruct_on_grid(points_of(points), {field_of(u)}, grid, options);
  expect_equal(fit, points, u, grid, equivalent(options, grid, 0), "cone");
  options.neighbours.reset();
  EXPECT_THROW(reconstruct_on_grid(points_of(points), {field_of(u)}, grid, options),
               InvalidArgument);
}

// Also at nodes that are fitted anew from their particles.
TYPED_TEST(GridEquality, ParticleWeights) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto grid = uneven_grid<Scalar, D>();
  for (const auto& cloud : hostile_clouds<Scalar, D>())
    for (int degree = 0; degree <= 2; ++degree) {
      std::vector<double> weights;
      for (std::size_t p = 0; p < cloud.points.size(); ++p)
        weights.push_back(static_cast<double>(1 + p * 7 % 10));
      const Matrix<Scalar> u = wave(cloud.points, 2);
      const Options options{.degree = degree, .particle_weights = weights};
      const auto fit = reconstruct_on_grid(points_of(cloud.points), {field_of(u)}, grid, options);
      expect_equal(fit, cloud.points, u, grid, equivalent(options, grid, 2),
                   cloud.name + ", degree " + std::to_string(degree));
    }
}

// A particle of weight 2 counts like two particles.
TYPED_TEST(GridEquality, ParticleWeightsAreMultiplicities) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto once = random_points<Scalar, D>(D == 1 ? 50 : D == 2 ? 200 : 400, 8);
  std::vector<double> weights;
  PointList<Scalar, D> repeated;
  for (std::size_t p = 0; p < once.size(); ++p) {
    weights.push_back(static_cast<double>(1 + p % 3));
    for (std::size_t i = 0; i < 1 + p % 3; ++i) repeated.push_back(once[p]);
  }
  const Matrix<Scalar> u = wave(once, 3), v = wave(repeated, 3);
  const auto grid = uneven_grid<Scalar, D>();
  const auto fit =
      reconstruct_on_grid(points_of(once), {field_of(u)}, grid, {.particle_weights = weights});
  const auto expected = reconstruct_on_grid(points_of(repeated), {field_of(v)}, grid);
  for (std::size_t i = 0; i < grid.size(); ++i) {
    const FitReport& report = fit.report()[i];
    ASSERT_EQ(report.degree, expected.report()[i].degree) << "node " << i;
    if (report.status == FitStatus::no_support) continue;
    EXPECT_LE(report.neighbours, expected.report()[i].neighbours);
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(fit.values()(i, c), expected.values()(i, c), allowed<Scalar>(report)) << i;
  }
  for (double& weight : weights) weight *= 1e-120;  // a unit of mass changes nothing
  const auto light =
      reconstruct_on_grid(points_of(once), {field_of(u)}, grid, {.particle_weights = weights});
  for (std::size_t i = 0; i < grid.size(); ++i)
    if (fit.report()[i].status != FitStatus::no_support) {
      EXPECT_NEAR(fit.values()(i, 0), light.values()(i, 0), allowed<Scalar>(fit.report()[i])) << i;
    }
}

}  // namespace
}  // namespace recon::testing
