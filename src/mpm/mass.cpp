// v_i = p_i / m_i and a_i = f_i / m_i + g, or M v = p and M a = f + M g with the consistent mass
// M_ij = sum_p m_p S_ip S_jp (Andersen, Andersen 2007, eq. 10, 17).
#include "core/brief.hpp"
#include "mpm/policies.hpp"

namespace recon::mpm {
namespace {

template <int D>
class ConsistentMass : public MassPolicy<D> {
 public:
  using MassPolicy<D>::MassPolicy;

  // Of all nodes that are not too light.
  void accelerate(const State<D>& s, const FromParticles& from, const BoundaryPolicy<D>& boundaries,
                  Nodes<D>& nodes) const override {
    MassPolicy<D>::accelerate(s, from, boundaries, nodes);
    const Particles<D>& particles = s.particles;
    const Problem<D>& problem = this->problem_;
    with_shape(problem.method, [&](auto shape_of) {
      typename decltype(shape_of)::template Nodes<D> shape;
      for (std::size_t p = 0; p < particles.size(); ++p) {
        if (from.leaves_out(nodes.grid, particles.x[p])) continue;
        shape_of.shape(nodes.grid, particles, p, shape);
        add_mass(shape, particles.mass[p], nodes.mass_entries);
      }
    });
    nodes.mass_matrix = mass_matrix(nodes.mass.size(), nodes.mass_entries);

    const double lightest = lightest_node * nodes.heaviest();
    std::vector<bool> heavy(nodes.mass.size()), factored;
    for (std::size_t i = 0; i < heavy.size(); ++i) heavy[i] = std::abs(nodes.mass[i]) > lightest;
    MassSolver solver;
    // Component d of M x = right at the free nodes.
    const auto solve = [&](const std::vector<bool>& free, int d, const auto& right,
                           std::vector<Vector<D>>& x) {
      if (free != factored)
        if (const auto node = solver.factor(nodes.mass_matrix, free))
          throw Failure(s.steps, "node", nodes.number_in(problem.grid, *node),
                        "the consistent mass matrix is singular: the particles near this node do "
                        "not determine its velocity; use lumped mass, or more particles");
      factored = free;
      Eigen::VectorXd component(nodes.mass_matrix.rows());
      for (std::size_t i = 0; i < x.size(); ++i) component[static_cast<int>(i)] = right(i);
      component = solver.solve(component);
      for (std::size_t i = 0; i < x.size(); ++i)
        if (heavy[i]) x[i][d] = component[static_cast<int>(i)];
    };
    for (int d = 0; d < D; ++d)
      solve(
          heavy, d, [&](std::size_t i) { return nodes.momentum[i][d]; }, nodes.mapped);
    for (int d = 0; d < D; ++d) {
      std::vector<bool> free = heavy;
      for (const HeldComponent<D>& each : nodes.held)
        if (each.axis == d) free[each.node] = false;
      const auto force = [&](std::size_t i) {
        return nodes.force[i][d] + nodes.mass[i] * problem.gravity[d];
      };
      solve(free, d, force, nodes.acceleration);
    }
  }
};

}  // namespace

template <int D>
void MassPolicy<D>::accelerate(const State<D>&, const FromParticles&, const BoundaryPolicy<D>&,
                               Nodes<D>& nodes) const {
  const double heaviest = nodes.heaviest();
  nodes.mapped.resize(nodes.mass.size());
  nodes.acceleration.resize(nodes.mass.size());
  for (std::size_t i = 0; i < nodes.mass.size(); ++i)
    move_node<D>(nodes.mass[i], nodes.momentum[i].data(), nodes.force[i].data(),
                 this->problem_.gravity.data(), heaviest, nodes.mapped[i].data(),
                 nodes.acceleration[i].data());
}

template <int D>
void MassPolicy<D>::watch(std::int64_t step, Nodes<D>& nodes, MassSigns& signs) const {
  nodes.negative = 0;
  const Method& method = this->problem_.method;
  const bool elements = is_element(method.basis);
  if (!elements && method.quadrature == Quadrature::particles) return;
  const double heaviest = nodes.heaviest();
  const bool first = signs.of_nodes.empty();
  signs.of_nodes.resize(nodes.mass.size());
  for (std::size_t i = 0; i < nodes.mass.size(); ++i) {
    const double mass = nodes.is_known(i) ? nodes.mass[i] : 0;
    const auto sign = static_cast<signed char>(sign_of_mass(mass, heaviest));
    const auto found = [&] {
      return NegativeMass{step, nodes.number_in(this->problem_.grid, i), mass};
    };
    if (!first && sign * signs.of_nodes[i] < 0 && !signs.change) signs.change = found();
    signs.of_nodes[i] = sign;
    if (sign >= 0) continue;
    ++nodes.negative;
    if (!signs.negative) signs.negative = found();
    if (method.at_negative_mass == AtNegativeMass::stop)
      throw Failure(step, "node", found().node,
                    "its mass is negative (" + recon::detail::brief(mass) + "): " +
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
