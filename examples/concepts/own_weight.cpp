// A weight of your own: a type with w(q) and dw/dq, q = |x - x_p| / rho in [0, 1).
//
// Parameters are checked once, by validate(), when the weight is chosen; a value that is negative
// or not finite is an error that names q and w. Degree 1 is exact for linear data, whatever the
// weight; on a parabola the narrow weight errs less, because it looks at less of it.
#include <recon/points/generate.hpp>
#include <recon/recon.hpp>

#include <cmath>
#include <cstdio>

// w = (1 - q^2)^n.
struct PowerWeight {
  double n;
  double operator()(double q) const { return std::pow(1 - q * q, n); }
  double derivative(double q) const { return -2 * n * q * std::pow(1 - q * q, n - 1); }
  void validate() const {
    if (!(n >= 1 && n <= 50))
      throw recon::InvalidArgument("n", std::to_string(n), "must be from 1 to 50");
  }
};
static_assert(recon::RadialWeight<PowerWeight>);

int main() {
  const auto particles = recon::jittered_points<double, 1>(50, 0.3, 1);
  std::vector<double> line, parabola;
  for (const auto& [x] : particles) line.push_back(3 * x), parabola.push_back(x * x);
  const std::vector<double> target{0.5};

  for (const double n : {1.0, 4.0, 16.0}) {
    const auto fit =
        recon::reconstruct(recon::points_of(particles), recon::points_of(target),
                           {.weight = PowerWeight{n}, .neighbours = recon::Radius{0.2}});
    std::printf("n = %2.0f: line %.4f, error on the parabola %.5f\n", n,
                fit.apply(recon::field_of(line))(0, 0),
                fit.apply(recon::field_of(parabola))(0, 0) - 0.25);
  }
  try {
    recon::reconstruct(recon::points_of(particles), recon::points_of(target),
                       {.weight = PowerWeight{0}});
  } catch (const recon::InvalidArgument& error) {
    std::printf("n = 0: %s\n", error.what());
  }
}

// Output
// n =  1: line 1.5000, error on the parabola 0.00814
// n =  4: line 1.5000, error on the parabola 0.00376
// n = 16: line 1.5000, error on the parabola 0.00117
// n = 0: n = 0.000000: must be from 1 to 50
