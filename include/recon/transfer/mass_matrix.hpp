// The consistent mass matrix of particles on a grid, and the systems that it is for.
//
//     M_ij = sum_p m_p S_ip S_jp ,   M v = p ,   M a = f   (Andersen, Andersen 2007, eq. 10, 17)
//
// with S the functions of the grid at the particles. Its row sums are the lumped masses m_i. It is
// singular where the particles near a node do not determine its value: solve for the nodes that
// they do determine.
//
// ```cpp
//   const recon::CartesianGrid<1> grid(recon::SpaceVector<1>(0), recon::SpaceVector<1>(1), 0.5);
//   recon::LinearFunctions::Nodes<1> at;
//   recon::MassEntries entries;
//   for (const double x : {0.1, 0.2, 0.4, 0.7, 0.9}) {
//     recon::LinearFunctions{}.at(grid, recon::SpaceVector<1>(x), at);
//     recon::add_mass(at, 1.5, entries);
//   }
//   const Eigen::SparseMatrix<double> M = recon::mass_matrix(grid.size(), entries);
//   recon::MassSolver solver;
//   if (!solver.factor(M, {true, true, true})) {  // else: a node that is not determined
//     const Eigen::VectorXd ones = solver.solve(M * Eigen::VectorXd::Ones(3));
//   }
// ```
#pragma once

#include <Eigen/SparseCore>
#include <memory>
#include <optional>
#include <vector>

#include "recon/transfer/point_functions.hpp"

namespace recon {

// Entries of a matrix over nodes; several of one place add up.
using MassEntries = std::vector<Eigen::Triplet<double>>;

// Adds mass * S_i S_j for all pairs of nodes of a particle. Throws InvalidArgument for a mass that
// is not finite.
template <int D, class Count>
void add_mass(const NodeFunctions<D, Count>& at, double mass, MassEntries& entries) {
  detail::require(std::isfinite(mass), "mass", mass, "must be finite");
  for (std::size_t a = 0; a < at.size(); ++a)
    for (std::size_t b = 0; b < at.size(); ++b)
      entries.emplace_back(static_cast<int>(at.node[a]), static_cast<int>(at.node[b]),
                           mass * at.S[a] * at.S[b]);
}

// The matrix of so many nodes.
Eigen::SparseMatrix<double> mass_matrix(std::size_t nodes, const MassEntries& entries);

// The Cholesky decomposition of the part of a mass matrix that belongs to some of its nodes.
class MassSolver {
 public:
  MassSolver();
  ~MassSolver();

  // For the nodes that are `free`; the others are 0 in every solution. Returns the node that the
  // particles do not determine, where there is one: its pivot is below 1e-11 of its diagonal, so
  // rounding would decide. Then there is nothing to solve with. Throws InvalidArgument for a number
  // of free nodes that is not the matrix's.
  std::optional<std::size_t> factor(const Eigen::SparseMatrix<double>& matrix,
                                    const std::vector<bool>& free);
  // x with M x = right at the free nodes, and 0 elsewhere. Throws InvalidArgument without factors.
  Eigen::VectorXd solve(Eigen::VectorXd right) const;

 private:
  struct Factors;
  std::unique_ptr<Factors> factors_;
};

}  // namespace recon
