// v_i = p_i / m_i and a_i = f_i / m_i + g, or M v = p and M a = f + M g with the consistent mass
// M_ij = sum_p m_p S_ip S_jp (Andersen, Andersen 2007, eq. 10, 17).
#include <Eigen/SparseCholesky>

#include "mpm/brief.hpp"
#include "mpm/policies.hpp"

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

template <int D>
class ConsistentMass : public MassPolicy<D> {
 public:
  using MassPolicy<D>::MassPolicy;

  // Of all nodes that are not too light.
  void accelerate(const State<D>& s, const FromParticles& from, const BoundaryPolicy<D>& boundaries,
                  Nodes<D>& nodes) const override {
    MassPolicy<D>::accelerate(s, from, boundaries, nodes);
    const Particles<D>& particles = s.particles;
    const Grid<D>& grid = this->problem_.grid;
    with_shape(this->problem_.method, [&](auto shape_of) {
      typename decltype(shape_of)::template Nodes<D> shape;
      for (std::size_t p = 0; p < particles.size(); ++p) {
        if (from.leaves_out(grid, particles.x[p])) continue;
        shape_of.shape(grid, particles, p, shape);
        add_mass(shape, particles.mass[p], nodes.mass_entries);
      }
    });
    solve(s, boundaries, nodes);
  }

 private:
  void solve(const State<D>& s, const BoundaryPolicy<D>& boundaries, Nodes<D>& nodes) const {
    const double lightest = lightest_node * nodes.heaviest();
    const auto count = static_cast<int>(nodes.mass.size());
    nodes.mass_matrix.resize(count, count);
    nodes.mass_matrix.setFromTriplets(nodes.mass_entries.begin(), nodes.mass_entries.end());
    std::vector<bool> heavy(nodes.mass.size());
    for (std::size_t i = 0; i < heavy.size(); ++i) heavy[i] = std::abs(nodes.mass[i]) > lightest;

    Cholesky cholesky;
    const Sparse full = restricted(nodes.mass_matrix, heavy);
    factor(cholesky, full, s.steps);
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
      for (const auto& each : boundaries.held())
        if (each.axis == d) free[each.node] = false;
      if (free != factored) {
        factor(cholesky, restricted(full, free), s.steps);
        factored = free;
      }
      for (int i = 0; i < count; ++i)
        right[i] = free[i] ? nodes.force[i][d] + nodes.mass[i] * this->problem_.gravity[d] : 0;
      const Eigen::VectorXd acceleration = cholesky.solve(right);
      for (int i = 0; i < count; ++i)
        if (heavy[i]) nodes.acceleration[i][d] = acceleration[i];
    }
  }
};

}  // namespace

template <int D>
void MassPolicy<D>::accelerate(const State<D>&, const FromParticles&, const BoundaryPolicy<D>&,
                               Nodes<D>& nodes) const {
  const double lightest = lightest_node * nodes.heaviest();
  nodes.mapped.resize(nodes.mass.size());
  nodes.acceleration.resize(nodes.mass.size());
  for (std::size_t i = 0; i < nodes.mass.size(); ++i) {
    nodes.mapped[i].setZero();
    nodes.acceleration[i].setZero();
    if (nodes.mass[i] == 0) continue;
    nodes.mapped[i] = nodes.momentum[i] / nodes.mass[i];
    nodes.acceleration[i] = problem_.gravity;
    if (std::abs(nodes.mass[i]) > lightest) nodes.acceleration[i] += nodes.force[i] / nodes.mass[i];
  }
}

template <int D>
void MassPolicy<D>::watch(std::int64_t step, Nodes<D>& nodes, MassSigns& signs) const {
  nodes.negative = 0;
  const Method& method = problem_.method;
  const bool elements = is_element(method.basis);
  if (!elements && method.quadrature == Quadrature::particles) return;
  const double lightest = lightest_node * nodes.heaviest();
  const bool first = signs.of_nodes.empty();
  signs.of_nodes.resize(nodes.mass.size());
  for (std::size_t i = 0; i < nodes.mass.size(); ++i) {
    const double mass = nodes.mass[i];
    const auto sign = static_cast<signed char>(mass > lightest ? 1 : mass < -lightest ? -1 : 0);
    const NegativeMass found{step, i, mass};
    if (!first && sign * signs.of_nodes[i] < 0 && !signs.change) signs.change = found;
    signs.of_nodes[i] = sign;
    if (sign >= 0) continue;
    ++nodes.negative;
    if (!signs.negative) signs.negative = found;
    if (method.stop_at_negative_mass)
      throw Failure(step, "node", i,
                    "its mass is negative (" + brief(mass) + "): " +
                        (elements ? "the functions of " + std::string(name_of(method.basis)) +
                                        " are negative in parts"
                                  : "the fitted density is, near it"));
  }
}

template <int D>
std::unique_ptr<const MassPolicy<D>> make_mass(const Problem<D>& problem) {
  if (problem.method.mass == MassMatrix::consistent)
    return std::make_unique<ConsistentMass<D>>(problem);
  return std::make_unique<MassPolicy<D>>(problem);
}

#define RECON_INSTANTIATE(D)    \
  template class MassPolicy<D>; \
  template std::unique_ptr<const MassPolicy<D>> make_mass(const Problem<D>&);
RECON_DIMENSIONS(RECON_INSTANTIATE)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
