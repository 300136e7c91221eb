// What the tests of this room share: the menu of scalar types and dimensions.
#pragma once

#include <gtest/gtest.h>

#include "support/clouds.hpp"

namespace recon::testing {

template <class S, int Dimension>
struct Space {
  using Scalar = S;
  static constexpr int D = Dimension;
  using Point = std::array<S, Dimension>;
};

using Spaces = ::testing::Types<Space<float, 1>, Space<float, 2>, Space<float, 3>, Space<double, 1>,
                                Space<double, 2>, Space<double, 3>>;

// The argument that an InvalidArgument names; empty if nothing is thrown.
template <class Function>
std::string blamed(Function function) {
  try {
    function();
  } catch (const InvalidArgument& error) {
    return error.argument();
  }
  return {};
}

}  // namespace recon::testing
