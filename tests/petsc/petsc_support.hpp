// What the tests of the room share: clouds that every rank knows as a whole, and each rank's part.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <petscsys.h>

#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "recon/petsc/distributed_grid.hpp"
#include "recon/points/make_view.hpp"

namespace recon::testing {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic>;
template <int D>
using Points = std::vector<std::array<double, D>>;

// Of SIGURG, from before the session.
inline void handler_of_before(int) {}

inline const petsc::Communicator& world() {
  static const petsc::Communicator ranks(PETSC_COMM_WORLD);
  return ranks;
}

// A grid over the unit cube with other spacings along each axis; small enough for 1-D and 4 ranks.
template <int D>
StructuredGrid<double> unit_grid(std::array<std::size_t, 3> nodes = {23, 18, 13}) {
  StructuredGrid<double> grid;
  grid.dimension = D;
  for (int d = 0; d < D; ++d) {
    grid.counts[d] = nodes[d];
    grid.spacing[d] = 1.0 / static_cast<double>(nodes[d] - 1);
  }
  return grid;
}

// Points in a box, the same on all ranks. Every seventh (0: none) lies on a node, so that some are on
// planes and corners between ranks.
template <int D>
Points<D> points_in(const StructuredGrid<double>& grid, std::size_t count, double beyond,
                    unsigned seed, std::size_t on_node = 7) {
  std::mt19937_64 random(seed);
  Points<D> points(count);
  for (std::size_t p = 0; p < count; ++p)
    for (int d = 0; d < D; ++d) {
      const double width = grid.spacing[d] * static_cast<double>(grid.counts[d] - 1);
      const double part = std::uniform_real_distribution<double>(-beyond, 1 + beyond)(random);
      points[p][d] = grid.origin[d] + part * width;
      if (on_node > 0 && p % on_node == 0)
        points[p][d] = grid.coordinate(
            static_cast<std::size_t>(std::clamp(part * static_cast<double>(grid.counts[d] - 1), 0.0,
                                                static_cast<double>(grid.counts[d] - 1))),
            d);
    }
  return points;
}

// Smooth data of the order of one.
template <std::size_t D>
Matrix waves(const std::vector<std::array<double, D>>& points, int components) {
  Matrix u(points.size(), components);
  for (std::size_t p = 0; p < points.size(); ++p)
    for (int c = 0; c < components; ++c) {
      double phase = c;
      for (std::size_t d = 0; d < D; ++d) phase += (2.0 + static_cast<double>(d)) * points[p][d];
      u(static_cast<Eigen::Index>(p), c) = std::sin(phase);
    }
  return u;
}

// The numbers of the points that belong to this rank.
template <std::size_t D, class RankOf>
std::vector<std::size_t> mine(const std::vector<std::array<double, D>>& points,
                              const petsc::Communicator& ranks, const RankOf& rank_of) {
  std::vector<std::size_t> numbers;
  for (std::size_t p = 0; p < points.size(); ++p)
    if (rank_of(p) == ranks.rank()) numbers.push_back(p);
  return numbers;
}

template <std::size_t D>
std::vector<std::array<double, D>> chosen(const std::vector<std::array<double, D>>& points,
                                          const std::vector<std::size_t>& numbers) {
  std::vector<std::array<double, D>> some;
  for (const std::size_t p : numbers) some.push_back(points[p]);
  return some;
}
inline Matrix chosen(const Matrix& rows, const std::vector<std::size_t>& numbers) {
  Matrix some(numbers.size(), rows.cols());
  for (std::size_t i = 0; i < numbers.size(); ++i)
    some.row(static_cast<Eigen::Index>(i)) = rows.row(static_cast<Eigen::Index>(numbers[i]));
  return some;
}

template <std::size_t D>
std::array<double, 3> padded(const std::array<double, D>& x) {
  std::array<double, 3> y{};
  std::copy(x.begin(), x.end(), y.begin());
  return y;
}

// Points that may be none, of any number of coordinates.
template <std::size_t D>
PointsView<double> view_of(const std::vector<std::array<double, D>>& points) {
  constexpr std::ptrdiff_t step = sizeof(std::array<double, D>);
  std::array<const void*, 3> first{};
  for (std::size_t d = 0; d < D && !points.empty(); ++d) first[d] = &points[0][d];
  return {points.size(), static_cast<int>(D), first, {step, step, step}};
}
inline FieldView<double> field_view(const Matrix& rows) {
  return {static_cast<std::size_t>(rows.rows()), static_cast<int>(rows.cols()), rows.data(),
          sizeof(double), rows.rows() * static_cast<std::ptrdiff_t>(sizeof(double))};
}

// What() of the exception that all ranks must throw; empty where this rank throws none.
template <class Call>
std::string refusal(const Call& call) {
  try {
    call();
  } catch (const InvalidArgument& e) {
    return e.what();
  }
  return "";
}

}  // namespace recon::testing
