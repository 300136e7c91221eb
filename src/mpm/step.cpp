#include "recon/mpm/step.hpp"

#include "mpm/policies.hpp"

namespace recon::mpm {

template <int D>
void Step<D>::operator()(State<D>& s, double dt) {
  to_nodes(s);          // 1, 2
  to_particles(s, dt);  // 3, 4
}

template <int D>
void Step<D>::to_nodes(State<D>& s) {
  const auto& [quadrature, map, mass, boundaries, loads, damping, images, update] = *policies_;
  if (parts_) parts_->copy_to(s);
  loads.body_force(s, body_force_);
  images.make(s, body_force_, nodes_);
  see(parts_ ? seen_by(*problem_, s, nodes_.images) : Window<D>::of(problem_->grid));
  nodes_.clear(problem_->method.has_light_nodes());
  // 1  particles to nodes: m_i, f_i and p_i by the quadrature, v_i = p_i / m_i or a fit
  const FromParticles from = quadrature->over_cells(s, body_force_, cells_, nodes_);
  map->to_nodes(s, body_force_, from, nodes_);
  loads.to_nodes(s, parts_, s.particles.size(), nodes_);
  images.share(s, nodes_);
  if (parts_) nodes_.heaviest_of_parts = parts_->largest(nodes_.heaviest_known());
  mass->watch(s.steps, nodes_, signs_);
  mass->accelerate(s, from, boundaries, nodes_);  // 2  a_i = f_i / m_i + g
  map->velocities(s, parts_, nodes_);
  damping.slow(boundaries, nodes_);
  nodes_.velocity = nodes_.mapped;
  boundaries.hold(s.time, problem_->method.velocity_lag(s.last_dt), nodes_);
}

template <int D>
void Step<D>::to_particles(State<D>& s, double dt) {
  policies_->update->move(*this, s, dt);  // 3  v_p, x_p, L_p; F, stress, history
}  // 4  the grid is forgotten

template <int D>
void Step<D>::see(const Window<D>& window) {
  if (nodes_.grid.size() > 0 && nodes_.window == window) return;
  const Grid<D> grid_before = nodes_.grid;
  const Window<D> before = nodes_.window;
  nodes_.window = window;
  nodes_.grid = parts_ ? window.part_of(problem_->grid) : problem_->grid;
  nodes_.held = policies_->boundaries.held_in(nodes_.grid, window.first);
  if (signs_.of_nodes.empty()) return;
  // Those of the nodes that were there before.
  std::vector<signed char> signs(nodes_.grid.size(), 0);
  for (std::size_t i = 0; i < signs_.of_nodes.size(); ++i)
    if (const auto here = window.place_of(problem_->grid, nodes_.grid,
                                          before.number_in(problem_->grid, grid_before, i)))
      signs[*here] = signs_.of_nodes[i];
  signs_.of_nodes = std::move(signs);
}

template <int D>
Step<D>::Step(Problem<D> problem, std::size_t particles, OtherParts<D>* parts) : parts_(parts) {
  constexpr std::size_t fewest_for_threads = 2000;  // fewer are done before threads have started
  problem.method.validate(D);
  if (parts) require_parts(problem);
  if (particles < fewest_for_threads) problem.threads = 1;
  problem.particles = {};
  problem_ = std::make_shared<const Problem<D>>(std::move(problem));
  policies_ = std::make_shared<const Policies<D>>(*problem_);
}

template <int D>
std::vector<Vector<D>> Step<D>::load_forces(const State<D>& s) const {
  if (problem_->loads.empty()) return {};
  Nodes<D> loaded;
  loaded.grid = nodes_.grid;
  loaded.clear(false);
  policies_->loads.to_nodes(s, parts_, s.own(), loaded);
  return std::move(loaded.force);
}

template <int D>
void Step<D>::forget() {
  nodes_ = {};
  cells_ = {};
  signs_ = {};
}

template class Step<1>;
template class Step<2>;
template class Step<3>;

}  // namespace recon::mpm
