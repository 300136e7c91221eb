#include "recon/transfer/mass_matrix.hpp"

#include <Eigen/SparseCholesky>

namespace recon {
namespace {

using detail::require;
using Sparse = Eigen::SparseMatrix<double>;

constexpr double least_pivot = 1e-11;  // of the diagonal: below it rounding decides

// With the rows and columns of the nodes that are not free made those of the unit matrix.
Sparse restricted(const Sparse& matrix, const std::vector<bool>& free) {
  MassEntries kept;
  for (int column = 0; column < matrix.outerSize(); ++column) {
    if (!free[column]) {
      kept.emplace_back(column, column, 1);
      continue;
    }
    for (Sparse::InnerIterator entry(matrix, column); entry; ++entry)
      if (free[entry.row()])
        kept.emplace_back(static_cast<int>(entry.row()), column, entry.value());
  }
  Sparse made(matrix.rows(), matrix.cols());
  made.setFromTriplets(kept.begin(), kept.end());
  return made;
}

}  // namespace

Sparse mass_matrix(std::size_t nodes, const MassEntries& entries) {
  for (const auto& entry : entries)
    require(entry.row() >= 0 && entry.col() >= 0 &&
                static_cast<std::size_t>(std::max(entry.row(), entry.col())) < nodes,
            "node of an entry of the mass matrix", std::max(entry.row(), entry.col()),
            "must be one of the grid's");
  Sparse matrix(static_cast<Eigen::Index>(nodes), static_cast<Eigen::Index>(nodes));
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

struct MassSolver::Factors {
  Eigen::SimplicialLDLT<Sparse> cholesky;
  std::vector<bool> free;
};

MassSolver::MassSolver() = default;
MassSolver::~MassSolver() = default;

std::optional<std::size_t> MassSolver::factor(const Sparse& matrix, const std::vector<bool>& free) {
  require(matrix.rows() == matrix.cols() && static_cast<Eigen::Index>(free.size()) == matrix.rows(),
          "free nodes", free.size(), "must be told for each row of the mass matrix");
  factors_.reset();
  auto made = std::make_unique<Factors>();
  const Sparse part = restricted(matrix, free);
  made->cholesky.compute(part);
  made->free = free;
  // The first pivot that is too small is that of the node which is not determined; one that is
  // zero ends the factorisation, so those after it are not looked at.
  const Eigen::VectorXd pivots = made->cholesky.vectorD(), diagonal = part.diagonal();
  const auto& place = made->cholesky.permutationPinv().indices();
  for (Eigen::Index k = 0; k < pivots.size(); ++k) {
    const int node = place.size() > 0 ? place[k] : static_cast<int>(k);
    if (!(pivots[k] > least_pivot * diagonal[node])) return static_cast<std::size_t>(node);
  }
  factors_ = std::move(made);
  return {};
}

Eigen::VectorXd MassSolver::solve(Eigen::VectorXd right) const {
  require(factors_ != nullptr, "mass matrix", "none", "needs a factor() before");
  require(right.size() == static_cast<Eigen::Index>(factors_->free.size()), "right side",
          right.size(), "must be one number for each node");
  for (Eigen::Index i = 0; i < right.size(); ++i)
    if (!factors_->free[static_cast<std::size_t>(i)]) right[i] = 0;
  return factors_->cholesky.solve(right);
}

}  // namespace recon
