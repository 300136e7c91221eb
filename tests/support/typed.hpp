// Typed tests over {float, double} x {1-D, 2-D, 3-D}.
#pragma once

#include <gtest/gtest.h>

#include <limits>
#include <string>

namespace recon::testing {

template <class S, int Dimension>
struct Case {
  using Scalar = S;
  static constexpr int D = Dimension;
  static constexpr double eps = std::numeric_limits<S>::epsilon();
};

using AllCases = ::testing::Types<Case<float, 1>, Case<float, 2>, Case<float, 3>, Case<double, 1>,
                                  Case<double, 2>, Case<double, 3>>;
using DoubleCases = ::testing::Types<Case<double, 1>, Case<double, 2>, Case<double, 3>>;

struct CaseNames {
  template <class C>
  static std::string GetName(int) {
    return std::string(sizeof(typename C::Scalar) == 4 ? "float" : "double") +
           std::to_string(C::D) + "D";
  }
};

}  // namespace recon::testing
