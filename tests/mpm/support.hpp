// Problems that the tests of the method share.
#pragma once

#include <gtest/gtest.h>

#include <ostream>
#include <random>
#include <string>
#include <vector>

#include "recon/runs/simulation.hpp"
#include "support/space.hpp"

namespace recon::mpm {

// What names of tests say of a method.
inline void PrintTo(const Method& method, std::ostream* out) {
  *out << method.name;
}

}  // namespace recon::mpm

namespace recon::mpm::test {

using recon::test::AllDimensions;
using recon::test::Dimension;
using recon::test::random_deformation;
using recon::test::uniform;

// Elastic particles that fill [lower, upper]^D of the grid [0, 1]^D, at rest.
template <int D>
Problem<D> block(int cells, double lower, double upper, const std::string& method = "mpm",
                 int per_cell = 2) {
  Problem<D> problem;
  problem.grid = Grid<D>(Vector<D>::Zero(), Vector<D>::Ones(), 1.0 / cells);
  problem.materials = {NeoHookean{Lame::from(1000, 0.3)}};
  problem.densities = {1000};
  problem.method = method_named(method);
  const double edge = problem.grid.h() / per_cell;
  const int count = static_cast<int>(std::lround((upper - lower) / edge));
  int all = 1;
  for (int d = 0; d < D; ++d) all *= count;
  for (int i = 0; i < all; ++i) {
    Vector<D> X;
    for (int d = 0, rest = i; d < D; ++d, rest /= count) X[d] = lower + (rest % count + 0.5) * edge;
    problem.particles.add(X, Matrix<D>::Identity() * (edge / 2), 1000, 0);
  }
  return problem;
}

// Elements with negative functions: the mass of a node may pass through zero.
inline bool has_negative_functions(const std::string& method) {
  const Basis basis = method_named(method).basis;
  return basis == Basis::q8 || basis == Basis::q9;
}

}  // namespace recon::mpm::test
