// A step of the plain material point method as written by hand for one method and one machine, that
// the driver is measured against: linear functions, the update `flip`, leapfrog, a neo-Hookean
// solid that fills the unit box, all particles of one volume and mass.
//
// Structs of arrays in the order of cells, sorted again when a particle has left its cell. To the
// nodes: the nodes of a cell are the lanes of a vector, and all particles of a cell are summed
// before its nodes are touched. Back: as many particles of a cell as a vector has lanes at once.
// Two colours of slabs for the threads. Compiled like hand_written.hpp. Nothing is checked.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

namespace hand_written {

// Over the nodes of a cell, or over as many particles.
typedef double FourDoubles __attribute__((vector_size(32)));
typedef double EightDoubles __attribute__((vector_size(64)));

template <int D>
class MpmStep {
 public:
  using Place = std::array<double, D>;

  // At rest in its reference state but for the velocities.
  MpmStep(int cells, const std::vector<Place>& x, const std::vector<Place>& v, double volume,
          double density, double lambda, double mu);
  void operator()(double dt, int threads);

  // Of all particles, in the order in which they were given.
  std::vector<Place> positions() const { return in_order(x_); }
  std::vector<Place> velocities() const { return in_order(v_); }

 private:
  using Numbers = std::vector<double>;
  static constexpr int corners = 1 << D;
  using Lanes = std::conditional_t<D == 2, FourDoubles, EightDoubles>;

  std::vector<Place> in_order(const std::array<Numbers, D>& of) const;
  std::size_t cell_of(std::size_t p) const;
  void sort();
  // The nodes of a cell, and its lower corner in cells.
  void look(std::size_t cell, std::array<std::uint32_t, corners>& node, Place& low) const;
  void add_cell(std::size_t cell);
  void move_cell(std::size_t cell, double dt, double kick, bool& left);
  template <class Work>
  void for_slabs(int threads, const Work& work) const;

  int cells_;
  std::size_t cell_count_ = 1, count_;
  double h_, mass_, volume_, lambda_, mu_, last_dt_ = 0;
  std::array<Numbers, D> x_, v_;
  std::array<Numbers, D * D> F_, pull_;  // pull: - volume * Cauchy stress
  Numbers energy_;
  std::vector<std::uint32_t> number_, first_;
  Numbers node_mass_;
  std::vector<Place> momentum_, force_, velocity_, acceleration_;
};

}  // namespace hand_written
