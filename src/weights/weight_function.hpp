// The weights over arrays, for each instruction set.
#pragma once

#include "core/dispatch.hpp"
#include "recon/weights/weight.hpp"

namespace recon {

// A function for a built-in weight: w[i] = w(q[i]) and, unless `slope` is null, slope[i] =
// w'(q[i]), 0 where q[i] >= 1. Its first argument is not used. Null for a weight that is
// not an enumerator.
RECON_FOR_EACH_SET(
    template <class Scalar> WeightFunction::Function<Scalar> weight_function(Weight weight))

}  // namespace recon
