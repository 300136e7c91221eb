// The choices that tests go through.
#pragma once

#include <array>

#include "recon/operators/reconstruct.hpp"

namespace recon::testing {

inline constexpr std::array all_solvers{Solver::moment_matrix, Solver::gram_schmidt, Solver::qr,
                                        Solver::svd};
inline constexpr std::array all_forms{WeightForm::radial, WeightForm::tensor_product};

}  // namespace recon::testing
