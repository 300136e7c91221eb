// fix recon/grid: fields of a running LAMMPS on a grid, and a body force from the grid to the
// atoms.
//
//   fix ID group recon/grid N spacing keyword values ...
//
//   N                    a frame every so many steps (and at the start of a run)
//   spacing              of the grid, a length; along periodic axes shrunk to fill the period
//   radius R             support radius, a length (default: 2 spacings)
//   degree D             of the fit of the velocity, 0 to 4 (default: 1)
//   stress c_ID          a compute stress/atom, whose field is written, too
//   drag G region-ID     nodes in the region pull at the atoms: G per time, see below
//   out NAME             files NAME_<step>.vti and NAME.pvd (default: none)
//   picture              and NAME_<step>.png
//
// At each node x of the grid, with images across periodic borders:
//
//   density    sum_p m_p W(x - x_p)                        mass / length^D
//   velocity   least squares of the atoms' velocities, with `status` of the fit
//   stress     sum_p S_p W(x - x_p), S_p from LAMMPS       its unit of pressure
//
// Drag. Each node in the region has the body force F_x = -G density velocity h^D, and the atoms get
// f_p = sum_x phi_p(x) F_x, with the transpose of the operator that took velocities to the nodes:
// as sum_p phi_p(x) = 1, the atoms get what the nodes lose, up to rounding. The forces stay with
// the atoms until the next frame. The fix's vector of six numbers is the impulse that the nodes
// have lost (summed over them, by the rule of velocity Verlet that the atoms follow) and the force
// that they exert now; its array per atom is f_p.
//
// The atoms' arrays x, v, mass and stress are viewed where they lie. One process, boxes that are
// orthogonal, all atoms of the group; errors of recon end the run as LAMMPS' own do.
#pragma once

#include <fix.h>

#include <Eigen/Core>
#include <string>
#include <vector>

#include "recon/io/write.hpp"
#include "recon/points/structured_grid.hpp"

namespace LAMMPS_NS {

class FixReconGrid : public Fix {
 public:
  FixReconGrid(LAMMPS* lammps, int count, char** words);
  ~FixReconGrid() override;

  int setmask() override;
  void init() override;
  void setup(int) override;
  void initial_integrate(int) override;
  void post_force(int) override;
  void final_integrate() override;
  void end_of_step() override;
  double compute_vector(int n) override;
  double memory_usage() override;

  // The forces travel with their atoms.
  void grow_arrays(int atoms) override;
  void copy_arrays(int from, int to, int) override;
  void set_arrays(int atom) override;
  int pack_exchange(int atom, double* buffer) override;
  int unpack_exchange(int atom, double* buffer) override;

  double seconds = 0;  // that recon has taken so far
  int frames = 0;

 private:
  struct Fields;
  [[noreturn]] void fail(const std::string& what) const;
  void read_words(int count, char** words);
  void reconstruct();
  void force_atoms(const Fields& fields);
  void write(const Fields& fields) const;

  double spacing_ = 0, radius_ = 0, drag_ = 0;
  int degree_ = 1;
  bool picture_ = false;
  std::string stress_, region_, name_;
  double half_step_ = 0;
  double held_[3] = {}, applied_[3] = {}, impulse_[3] = {};  // sums over the nodes
  mutable std::vector<recon::TimedFile> series_;
};

}  // namespace LAMMPS_NS
