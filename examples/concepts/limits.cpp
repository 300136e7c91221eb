// Limits: values that must not leave the range of their data.
//
// A fit of degree 2 overshoots beside a step from 0 to 1. With Limit::range each value stays
// between the least and the greatest datum in its support; values inside keep their bits.
#include <recon/recon.hpp>

#include <algorithm>
#include <cstdio>

int main() {
  std::vector<double> x, u, targets;
  for (int p = 0; p < 40; ++p) {
    x.push_back(p);
    u.push_back(p < 20 ? 0 : 1);
  }
  for (int t = 0; t <= 390; ++t) targets.push_back(0.1 * t);

  const auto fit = recon::reconstruct(recon::points_of(x), recon::points_of(targets),
                                      {.degree = 2, .neighbours = recon::Radius{4}});
  for (const recon::Limit limit : {recon::Limit::none, recon::Limit::range}) {
    recon::LimitCount count;
    const Eigen::MatrixXd value = fit.apply(recon::field_of(u), {.limit = limit, .count = &count});
    std::printf("from %6.3f to %.3f, %2zu of %td values limited\n", value.minCoeff() + 0.0,
                value.maxCoeff(), count.values, value.rows());
  }
}

// Output
// from -0.050 to 1.050,  0 of 391 values limited
// from  0.000 to 1.000, 44 of 391 values limited
