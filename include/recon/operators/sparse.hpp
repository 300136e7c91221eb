// An operator as an Eigen::SparseMatrix. A header of its own, as it includes Eigen's sparse module.
#pragma once

#include <Eigen/SparseCore>

#include "recon/operators/csr_operator.hpp"

namespace recon {

// Rows are targets times blocks (row t * blocks + b), columns particles; row-major. Entries of one
// particle in one row (periodic images) are summed. Rows without support are empty: there is no
// fill value. Throws InvalidArgument where the Sources have been updated since.
template <class Scalar>
Eigen::SparseMatrix<Scalar, Eigen::RowMajor, std::int64_t> to_sparse(
    const CsrOperator<Scalar>& op) {
  std::vector<Eigen::Triplet<Scalar, std::int64_t>> triplets;
  triplets.reserve(op.entries() * static_cast<std::size_t>(op.blocks()));
  const int blocks = op.blocks();
  for (std::size_t t = 0; t < op.rows(); ++t) {
    const auto row = op.row(t);
    for (std::size_t i = 0; i < row.size(); ++i)
      for (int b = 0; b < blocks; ++b)
        if (const Scalar value = row.value(i, b); value != 0)
          triplets.emplace_back(static_cast<std::int64_t>(t) * blocks + b, row.particle(i), value);
  }
  Eigen::SparseMatrix<Scalar, Eigen::RowMajor, std::int64_t> matrix(
      static_cast<std::int64_t>(op.rows()) * blocks, static_cast<std::int64_t>(op.columns()));
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  return matrix;
}

}  // namespace recon
