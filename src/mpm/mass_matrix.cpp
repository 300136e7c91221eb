#include "mpm/mass_matrix.hpp"

#include <Eigen/SparseCholesky>

namespace recon::mpm {
namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Cholesky = Eigen::SimplicialLDLT<Sparse>;

constexpr double least_pivot = 1e-11;  // of the diagonal: below it rounding decides

// `full` with the rows and columns of the nodes outside of `free` made those of the unit matrix.
Sparse restricted(const Sparse& full, const std::vector<bool>& free) {
  MassEntries kept;
  for (int column = 0; column < full.outerSize(); ++column) {
    if (!free[column]) {
      kept.emplace_back(column, column, 1);
      continue;
    }
    for (Sparse::InnerIterator entry(full, column); entry; ++entry)
      if (free[entry.row()])
        kept.emplace_back(static_cast<int>(entry.row()), column, entry.value());
  }
  Sparse made(full.rows(), full.cols());
  made.setFromTriplets(kept.begin(), kept.end());
  return made;
}

// The first pivot that is too small is that of the node which is not determined; one that is
// zero ends the factorisation, so those after it are not looked at.
void factor(Cholesky& cholesky, const Sparse& matrix, std::int64_t step) {
  cholesky.compute(matrix);
  const Eigen::VectorXd pivots = cholesky.vectorD(), diagonal = matrix.diagonal();
  const auto& place = cholesky.permutationPinv().indices();
  for (Eigen::Index k = 0; k < pivots.size(); ++k) {
    const int node = place.size() > 0 ? place[k] : static_cast<int>(k);
    if (pivots[k] > least_pivot * diagonal[node]) continue;
    throw Failure(step, "node", static_cast<std::size_t>(node),
                  "the consistent mass matrix is singular: the particles near this node do not "
                  "determine its velocity; use lumped mass, or more particles");
  }
}

}  // namespace

template <int D>
void solve_mass(const MassEntries& entries, double lightest, const Vector<D>& gravity,
                const std::vector<HeldVelocity>& held, std::int64_t step, Nodes<D>& nodes) {
  const auto count = static_cast<int>(nodes.mass.size());
  nodes.mass_matrix.resize(count, count);
  nodes.mass_matrix.setFromTriplets(entries.begin(), entries.end());
  std::vector<bool> heavy(nodes.mass.size());
  for (std::size_t i = 0; i < heavy.size(); ++i) heavy[i] = std::abs(nodes.mass[i]) > lightest;

  Cholesky cholesky;
  const Sparse full = restricted(nodes.mass_matrix, heavy);
  factor(cholesky, full, step);
  std::vector<bool> factored = heavy;
  Eigen::VectorXd right(count);
  for (int d = 0; d < D; ++d) {
    for (int i = 0; i < count; ++i) right[i] = heavy[i] ? nodes.momentum[i][d] : 0;
    const Eigen::VectorXd velocity = cholesky.solve(right);
    for (int i = 0; i < count; ++i)
      if (heavy[i]) nodes.mapped[i][d] = velocity[i];
  }
  for (int d = 0; d < D; ++d) {
    std::vector<bool> free = heavy;
    for (const HeldVelocity& each : held)
      if (each.axis == d) free[each.node] = false;
    if (free != factored) {
      factor(cholesky, restricted(full, free), step);
      factored = free;
    }
    for (int i = 0; i < count; ++i)
      right[i] = free[i] ? nodes.force[i][d] + nodes.mass[i] * gravity[d] : 0;
    const Eigen::VectorXd acceleration = cholesky.solve(right);
    for (int i = 0; i < count; ++i)
      if (heavy[i]) nodes.acceleration[i][d] = acceleration[i];
  }
}

template void solve_mass(const MassEntries&, double, const Vector<1>&,
                         const std::vector<HeldVelocity>&, std::int64_t, Nodes<1>&);
template void solve_mass(const MassEntries&, double, const Vector<2>&,
                         const std::vector<HeldVelocity>&, std::int64_t, Nodes<2>&);
template void solve_mass(const MassEntries&, double, const Vector<3>&,
                         const std::vector<HeldVelocity>&, std::int64_t, Nodes<3>&);

}  // namespace recon::mpm
