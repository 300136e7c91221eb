// What a step on a GPU (step_on.hpp) has to know of a problem, as plain numbers, and which problems
// it can take.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "recon/grid/reconstruct_on_grid.hpp"
#include "recon/mpm/problem.hpp"

namespace recon::mpm {

// The numbers of a grid, with the functions of CartesianGrid that functions of an axis ask for.
template <int D>
struct GridNumbers {
  double lower_[D], h_, inverse_h_;
  int cells_[D];

  constexpr double h() const { return h_; }
  constexpr double inverse_h() const { return inverse_h_; }
  constexpr const double* lower() const { return lower_; }
  constexpr double upper(int d) const { return lower_[d] + cells_[d] * h_; }
  constexpr int cells(int d) const { return cells_[d]; }
  constexpr double node(int i, int d) const { return lower_[d] + i * h_; }
  constexpr int cell(double x, int d) const {
    return recon::detail::cell_of_axis(x, lower_[d], h_, cells_[d]);
  }
  constexpr void require_coordinate(double, int) const {}
  constexpr bool contains(const double* x) const {
    for (int d = 0; d < D; ++d)
      if (!recon::detail::lies_on_axis(x[d], lower_[d], upper(d), h_)) return false;
    return true;
  }

  constexpr std::size_t cell_count() const {
    std::size_t count = 1;
    for (int d = 0; d < D; ++d) count *= static_cast<std::size_t>(cells_[d]);
    return count;
  }
  constexpr std::size_t node_count() const {
    std::size_t count = 1;
    for (int d = 0; d < D; ++d) count *= static_cast<std::size_t>(cells_[d]) + 1;
    return count;
  }
  constexpr std::size_t cell_number(const int* index) const {
    std::size_t number = 0;
    for (int d = D - 1; d >= 0; --d)
      number = number * static_cast<std::size_t>(cells_[d]) + static_cast<std::size_t>(index[d]);
    return number;
  }
  constexpr std::size_t node_number(const int* index) const {
    std::size_t number = 0;
    for (int d = D - 1; d >= 0; --d)
      number =
          number * (static_cast<std::size_t>(cells_[d]) + 1) + static_cast<std::size_t>(index[d]);
    return number;
  }
  constexpr void cell_index(std::size_t number, int* index) const { index_of(number, 0, index); }
  constexpr void node_index(std::size_t number, int* index) const { index_of(number, 1, index); }
  constexpr double cell_volume() const {
    double volume = 1;
    for (int d = 0; d < D; ++d) volume *= h_;
    return volume;
  }
  // Calls use(cell, its number) for the cells from `below` before the one with this index to `above`
  // behind it along each axis, as far as there are some.
  template <class Use>
  constexpr void for_cells_around(const int* index, int below, int above, const Use& use) const {
    int from[3] = {0, 0, 0}, to[3] = {0, 0, 0}, cell[3] = {0, 0, 0};
    for (int d = 0; d < D; ++d) {
      from[d] = index[d] - below < 0 ? 0 : index[d] - below;
      to[d] = index[d] + above < cells_[d] ? index[d] + above : cells_[d] - 1;
    }
    for (cell[2] = from[2]; cell[2] <= to[2]; ++cell[2])
      for (cell[1] = from[1]; cell[1] <= to[1]; ++cell[1])
        for (cell[0] = from[0]; cell[0] <= to[0]; ++cell[0]) use(cell, cell_number(cell));
  }

 private:
  // Of the number of a cell, or of a node, of which there is one more along each axis.
  constexpr void index_of(std::size_t number, int more, int* index) const {
    for (int d = 0; d < D; ++d) {
      const auto count = static_cast<std::size_t>(cells_[d] + more);
      index[d] = static_cast<int>(number % count);
      number /= count;
    }
  }
};

// A face of the grid whose nodes have no normal velocity.
template <int D>
struct WallNumbers {
  int axis;
  bool upper;
  double face, from[D], to[D];
};

// A component of the velocity of a node that the problem gives.
struct HeldNode {
  std::uint32_t node;
  int axis;
  bool varies;
};

template <int D>
struct Plan {
  // Of a problem with a form for a GPU. Its particles are not needed.
  explicit Plan(const Problem<D>& problem);

  GridNumbers<D> grid;
  StructuredGrid<double> nodes, centres;  // of the cells
  Kept kept;
  Method method;
  TimeOptions time;
  Damping damping;
  double courant;
  double gravity[D];
  std::vector<Material> materials;
  std::vector<WallNumbers<D>> walls;
  std::vector<HeldNode> held;  // each component once
  // The velocities of `held` at a time.
  std::function<std::vector<double>(double time)> held_velocities;
};

// Throws InvalidArgument for a problem with a choice that has no form for a GPU: which, and which
// others have one.
template <int D>
void require_form_on_gpu(const Problem<D>& problem);

}  // namespace recon::mpm
