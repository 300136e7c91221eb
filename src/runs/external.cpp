#include "recon/runs/external.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "mpm/policies.hpp"

namespace recon::mpm {
namespace {

// Gravity, body force and loads at a time, sums of absolute values.
template <int D>
double applied(const Problem<D>& problem, const State<D>& s,
               const std::vector<Vector<D>>& body_force, const std::vector<Vector<D>>& loads) {
  double sum = 0;
  for (std::size_t p = 0; p < s.own(); ++p) {
    Vector<D> b = problem.gravity;
    if (!body_force.empty()) b += body_force[p];
    sum += s.particles.mass[p] * b.template lpNorm<1>();
  }
  for (const Vector<D>& load : loads) sum += load.template lpNorm<1>();
  return sum;
}

// How much body force and loads differ between the state's time and `end`, in the same sum.
template <int D>
double still_to_come(const View<D>& view, const std::vector<Vector<D>>& loads, double end) {
  const Problem<D>& problem = view.problem();
  const Particles<D>& particles = view.particles();
  if (!std::isfinite(end) || (!problem.body_force && problem.loads.empty())) return 0;
  std::vector<Vector<D>> more;
  if (problem.body_force) {
    more.assign(particles.size(), Vector<D>::Zero());
    problem.body_force(particles, end, problem.threads, more);
    const std::vector<Vector<D>>& now = view.step().body_force();
    for (std::size_t p = 0; p < more.size(); ++p) more[p] -= now[p];
  }
  std::vector<Vector<D>> loaded;
  if (!loads.empty()) {
    State<D> at_end = view.state();
    at_end.time = end;
    loaded = view.step().load_forces(at_end);
    for (std::size_t i = 0; i < loaded.size(); ++i) loaded[i] -= loads[i];
  }
  double sum = 0;
  for (std::size_t p = 0; p < std::min(more.size(), view.state().own()); ++p)
    sum += particles.mass[p] * more[p].template lpNorm<1>();
  for (const Vector<D>& each : loaded) sum += each.template lpNorm<1>();
  view.sum({&sum, 1});
  return sum;
}

}  // namespace

template <int D>
ExternalForces<D> external_forces(const Simulation<D>& simulation) {
  return external_forces(View<D>(simulation));
}

template <int D>
ExternalForces<D> external_forces(const View<D>& view) {
  view.require_mapped("external forces");
  ExternalForces<D> forces = external_forces(view.state(), view.step());
  std::array<double, 4> sums{forces.power, forces.unbalanced, forces.held, forces.applied};
  view.sum(sums);
  forces.power = sums[0];
  forces.unbalanced = sums[1];
  forces.held = sums[2];
  forces.applied = sums[3];
  return forces;
}

template <int D>
ExternalForces<D> external_forces(const State<D>& s, const Step<D>& step) {
  const Problem<D>& problem = step.problem();
  const Nodes<D>& nodes = step.nodes();
  const double half = problem.method.velocity_lag(s.last_dt);
  const std::size_t count = nodes.mass.size();
  ExternalForces<D> out;
  out.loads = step.load_forces(s);
  const auto now = [&](std::size_t i) -> Vector<D> {
    return nodes.velocity[i] + half * nodes.acceleration[i];
  };
  for (std::size_t i = 0; i < out.loads.size(); ++i) out.power += out.loads[i].dot(now(i));

  std::vector<Vector<D>> undamped = nodes.acceleration;
  if (!nodes.damping.empty()) {
    const std::vector<Vector<D>> slowing = nodes.times_mass(nodes.damping);
    for (std::size_t i = 0; i < count; ++i) {
      out.power += nodes.share_of(i) * slowing[i].dot(now(i));
      undamped[i] -= nodes.damping[i];
    }
  }
  const std::vector<Vector<D>> gained = nodes.times_mass(undamped);
  const auto force = [&](std::size_t i) -> Vector<D> {
    return nodes.force[i] + nodes.mass[i] * problem.gravity;
  };
  std::vector<std::array<bool, D>> is_held(count, std::array<bool, D>{});
  for (const HeldComponent<D>& held : nodes.held) {
    bool& seen = is_held[held.node][static_cast<std::size_t>(held.axis)];
    const double R =
        nodes.share_of(held.node) * (gained[held.node][held.axis] - force(held.node)[held.axis]);
    const auto number = static_cast<std::uint32_t>(nodes.number_in(problem.grid, held.node));
    out.reactions.push_back({held.boundary, number, held.axis, R, !seen});
    if (!seen) {
      out.held += std::abs(R);
      out.power += R * now(held.node)[held.axis];
    }
    seen = true;
  }
  const double lightest = lightest_node * nodes.heaviest();
  for (std::size_t i = 0; i < count; ++i) {
    if (!(std::abs(nodes.mass[i]) > lightest)) continue;
    const Vector<D> f = force(i);
    for (int d = 0; d < D; ++d)
      if (!is_held[i][static_cast<std::size_t>(d)])
        out.unbalanced += nodes.share_of(i) * std::abs(f[d]);
  }
  out.applied = applied(problem, s, step.body_force(), out.loads);
  return out;
}

template <int D>
RestMeasure rest_of(const View<D>& view, const ExternalForces<D>& forces, double node_kinetic,
                    double strain, double tolerance) {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  const double acting = std::max(forces.held, forces.applied);
  RestMeasure found{acting > 0 ? forces.unbalanced / acting : infinite,
                    strain > 0 ? node_kinetic / strain : infinite, false};
  if (!(found.unbalanced < tolerance && found.kinetic < tolerance)) return found;
  const double end = view.problem().time.end;
  const auto at_rest = [&](const auto& held) {
    if (view.nodes().velocity[held.node][held.axis] != 0) return false;
    return !held.velocity->varies() || !std::isfinite(end) || (*held.velocity)(held.x, end) == 0;
  };
  for (const HeldComponent<D>& held : view.nodes().held)
    if (!at_rest(held)) return found;
  found.reached = still_to_come(view, forces.loads, end) <= tolerance * acting;
  return found;
}

#define RECON_INSTANTIATE(D)                                                   \
  template ExternalForces<D> external_forces(const Simulation<D>&);            \
  template ExternalForces<D> external_forces(const View<D>&);                  \
  template ExternalForces<D> external_forces(const State<D>&, const Step<D>&); \
  template RestMeasure rest_of(const View<D>&, const ExternalForces<D>&, double, double, double);
RECON_INSTANTIATE(1)
RECON_INSTANTIATE(2)
RECON_INSTANTIATE(3)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
