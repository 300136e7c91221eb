#include "recon/mpm/simulation.hpp"

#include <cmath>
#include <cstdio>

#include "core/flatten.hpp"
#include "mpm/cell_quadrature.hpp"
#include "mpm/gauss_quadrature.hpp"
#include "mpm/mass_matrix.hpp"
#include "mpm/modes.hpp"
#include "mpm/velocity_fit.hpp"
#include "recon/core/parallel.hpp"
#include "recon/transfer/scatter.hpp"

namespace recon::mpm {
namespace {

using recon::detail::require;

constexpr std::size_t particles_per_block = 1024;
constexpr std::size_t fewest_for_threads =
    2000;                                // a step of fewer is over before threads have started
constexpr double lightest_node = 1e-10;  // of the heaviest
constexpr double light_node = 0.1;       // of the heaviest
constexpr double most_strained = 0.5;    // k dt K / m of a light node
constexpr double put_back = 1e-3;        // of a cell beyond a wall

// For messages.
std::string brief(double value, int digits = 4) {
  char text[32];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return text;
}

template <int D, class Shape>
struct Scratch {
  typename Shape::template Nodes<D> shape;
  PolynomialModes<D> modes;
  std::vector<Vector<D>> velocity;  // that the particle shows to each of its nodes
};

}  // namespace

Failure::Failure(std::int64_t step, const char* place, std::size_t number, const std::string& what)
    : std::runtime_error("step " + std::to_string(step) + ", " + place + " " +
                         std::to_string(number) + ": " + what),
      step_(step),
      number_(number) {}

template <int D>
Simulation<D>::Simulation(Problem<D> problem) : problem_(std::move(problem)) {
  problem_.validate();
  Particles<D>& particles = problem_.particles;
  if (particles.size() < fewest_for_threads) problem_.threads = 1;
  if (problem_.method.domain == Domain::cpdi2 && particles.corners.empty())
    for (std::size_t p = 0; p < particles.size(); ++p)
      particles.corners.push_back(particles.domain(p));
  with_shape(problem_.method, [&](auto shape_of) { start_modes(shape_of); });
  find_held();
}

// Of the linear fields v_p + L_p d.
template <int D>
template <class Shape>
void Simulation<D>::start_modes(Shape shape_of) {
  if constexpr (is_product<D, Shape>) {
    const VelocityMap map = problem_.method.velocity;
    const int count = mode_count(map, D);
    Particles<D>& particles = problem_.particles;
    if (count == 0) return;
    if (!particles.modes.empty()) {
      require(particles.modes.size() == particles.size() * static_cast<std::size_t>(count),
              "modes of the particles", particles.modes.size(),
              "must be those of the method for each particle, or none");
      return;
    }
    particles.modes.assign(particles.size() * static_cast<std::size_t>(count), Vector<D>::Zero());
    PolynomialModes<D> modes;
    for (std::size_t p = 0; p < particles.size(); ++p) {
      modes.fill(problem_.grid, shape_of.functions.axes(problem_.grid, particles.x[p]),
                 particles.x[p], mode_set(map));
      for (int d = 0; d < D; ++d) {
        const int r = linear_mode(mode_set(map), d);
        particles.modes[p * static_cast<std::size_t>(count) + static_cast<std::size_t>(r)] =
            particles.L[p].col(d);
      }
    }
  }
}

template <int D>
void Simulation<D>::find_held() {
  const Grid<D>& grid = problem_.grid;
  for (const Boundary<D>& boundary : problem_.boundaries) {
    const auto plane = static_cast<std::size_t>(
        std::lround((boundary.at - grid.lower()[boundary.axis]) / grid.h()));
    if (boundary.velocity[boundary.axis] == 0.0) {
      if (plane == 0) walls_[boundary.axis][0] = true;
      if (plane == static_cast<std::size_t>(grid.cells(boundary.axis)))
        walls_[boundary.axis][1] = true;
    }
    for (std::size_t i = 0; i < grid.size(); ++i) {
      if (grid.nodes().index(i)[boundary.axis] != plane) continue;
      for (int d = 0; d < D; ++d)
        if (boundary.velocity[d])
          held_.push_back({static_cast<std::uint32_t>(i), d, *boundary.velocity[d]});
    }
  }
}

template <int D>
const Nodes<D>& Simulation<D>::nodes() const {
  require(!nodes_.mass.empty(), "nodes", "none", "need a map() or a step() before");
  return nodes_;
}
template <int D>
const Cells<D>& Simulation<D>::cells() const {
  nodes();
  return cells_;
}

// After a failure nothing is what it says.
template <int D>
void Simulation<D>::map() {
  require(nodes_state_ != NodesState::broken, "simulation", "failed",
          "cannot go on after a step that failed; restore() brings back a state");
  if (nodes_state_ == NodesState::mapped) return;
  nodes_state_ = NodesState::broken;
  fill_nodes();
  nodes_state_ = NodesState::mapped;
}

template <int D>
void Simulation<D>::step(double dt) {
  require(dt > 0 && std::isfinite(dt), "time step", dt, "must be positive and finite");
  require(time_ + dt > time_, "time step", dt, "is too short to move the clock");
  map();
  nodes_state_ = NodesState::broken;
  advance(dt);
  nodes_state_ = NodesState::stepped;
}

// Step 1. What the papers call "map from material points to the grid".
template <int D>
void Simulation<D>::fill_nodes() {
  const Particles<D>& particles = problem_.particles;
  const Method& method = problem_.method;
  acceleration_.assign(problem_.body_force ? particles.size() : 0, Vector<D>::Zero());
  if (problem_.body_force) problem_.body_force(particles, time_, problem_.threads, acceleration_);

  const std::size_t count = problem_.grid.size();
  nodes_.mass.assign(count, 0);
  nodes_.momentum.assign(count, Vector<D>::Zero());
  nodes_.force.assign(count, Vector<D>::Zero());
  const bool light_nodes = method.domain == Domain::point && method.mass == MassMatrix::lumped &&
                           method.basis == Basis::linear && !is_cell(method.quadrature) &&
                           method.stress == StressUpdate::last &&
                           method.update != Update::runge_kutta;
  nodes_.internal.assign(light_nodes ? count : 0, Vector<D>::Zero());
  nodes_.stiffness.assign(light_nodes ? count : 0, 0);
  MassEntries mass_entries;  // from Gauss points, of a consistent mass
  if (is_gauss(method.quadrature)) {
    cells_.fill = full_cells(problem_);
    integrate_gauss(problem_, acceleration_, cells_.fill, nodes_,
                    method.mass == MassMatrix::consistent ? &mass_entries : nullptr);
  }
  with_shape(method, [&](auto shape_of) { scatter(shape_of); });
  if (is_cell(method.quadrature)) integrate_cells(problem_, acceleration_, cells_, nodes_);

  double heaviest = 0;
  for (const double mass : nodes_.mass) heaviest = std::max(heaviest, std::abs(mass));
  const double lightest = lightest_node * heaviest;
  watch_mass(lightest);
  nodes_.mapped.resize(count);
  nodes_.acceleration.resize(count);
  nodes_.unfitted = 0;
  for (std::size_t i = 0; i < count; ++i) {
    nodes_.mapped[i].setZero();
    nodes_.acceleration[i].setZero();
    if (nodes_.mass[i] == 0) continue;
    nodes_.mapped[i] = nodes_.momentum[i] / nodes_.mass[i];
    nodes_.acceleration[i] = problem_.gravity;
    if (std::abs(nodes_.mass[i]) > lightest)
      nodes_.acceleration[i] += nodes_.force[i] / nodes_.mass[i];
  }
  if (method.mass == MassMatrix::consistent) solve_consistent(std::move(mass_entries), lightest);
  if (is_fit(method.velocity)) fit_velocity(problem_, nodes_);
  if (method.momentum_correction &&
      (is_fit(method.velocity) || method.quadrature == Quadrature::gauss_cells))
    correct_momentum();
  nodes_.velocity = nodes_.mapped;
  hold_boundaries();
}

// Reports the first negative mass and the first change of sign, and stops where that is asked for.
template <int D>
void Simulation<D>::watch_mass(double lightest) {
  nodes_.negative = 0;
  const Method& method = problem_.method;
  const bool elements = is_element(method.basis);
  if (!elements && method.quadrature == Quadrature::particles) return;
  const bool first = signs_.empty();
  signs_.resize(nodes_.mass.size());
  for (std::size_t i = 0; i < nodes_.mass.size(); ++i) {
    const double mass = nodes_.mass[i];
    const auto sign = static_cast<signed char>(mass > lightest ? 1 : mass < -lightest ? -1 : 0);
    const NegativeMass found{steps_, i, mass};
    if (!first && sign * signs_[i] < 0 && !sign_change_) sign_change_ = found;
    signs_[i] = sign;
    if (sign >= 0) continue;
    ++nodes_.negative;
    if (!negative_mass_) negative_mass_ = found;
    if (method.stop_at_negative_mass)
      throw Failure(steps_, "node", i,
                    "its mass is negative (" + brief(mass) + "): " +
                        (elements ? "the functions of " + std::string(name_of(method.basis)) +
                                        " are negative in parts"
                                  : "the fitted density is, near it"));
  }
}

template <int D>
void Simulation<D>::solve_consistent(std::vector<Eigen::Triplet<double>> entries, double lightest) {
  const Particles<D>& particles = problem_.particles;
  with_shape(problem_.method, [&](auto shape_of) {
    typename decltype(shape_of)::template Nodes<D> shape;
    for (std::size_t p = 0; p < particles.size(); ++p) {
      if (is_gauss(problem_.method.quadrature) && in_full_cell(problem_, cells_.fill, p)) continue;
      shape_of.shape(problem_.grid, particles, p, shape);
      add_mass(shape, particles.mass[p], entries);
    }
  });
  solve_mass(entries, lightest, problem_.gravity, held_, steps_, nodes_);
}

template <int D>
template <class Shape>
void Simulation<D>::scatter(Shape shape_of) {
  const Particles<D>& particles = problem_.particles;
  const Grid<D>& grid = problem_.grid;
  const Method& method = problem_.method;
  const bool particle_quadrature = !is_cell(method.quadrature);
  const bool gauss = is_gauss(method.quadrature);
  const bool taylor = method.velocity == VelocityMap::taylor;
  const bool light_nodes = !nodes_.stiffness.empty();
  const auto modes = static_cast<std::size_t>(mode_count(method.velocity, D));
  const auto rows = [&](std::size_t p) { return shape_of.nodes_along(grid, particles, p, D - 1); };
  // Flattened, here and in gather(): with so many shapes the compiler runs out of what it inlines.
  const auto add = [&](std::size_t p, Scratch<D, Shape>& scratch) RECON_FLATTEN {
    if (gauss && in_full_cell(problem_, cells_.fill, p)) return;
    auto& shape = scratch.shape;
    const double volume = shape_of.shape(grid, particles, p, shape);
    const double mass = particles.mass[p];
    // `show` is the velocity that the particle shows to its node k.
    const auto spread = [&](const auto& show) {
      if (!particle_quadrature) {
        for (std::size_t k = 0; k < shape.size(); ++k)
          nodes_.momentum[shape.node[k]] += shape.S[k] * mass * show(k);
        return;
      }
      const Matrix<D> pull = -volume * particles.stress[p];
      const Vector<D> push =
          acceleration_.empty() ? Vector<D>::Zero() : Vector<D>(mass * acceleration_[p]);
      for (std::size_t k = 0; k < shape.size(); ++k) {
        const std::uint32_t i = shape.node[k];
        const double part = shape.S[k] * mass;
        nodes_.mass[i] += part;
        nodes_.momentum[i] += part * show(k);
        nodes_.force[i] += pull * shape.G[k] + shape.S[k] * push;
      }
      if (!light_nodes) return;
      const Lame& elastic = lame(problem_.materials[particles.body[p]]);
      const double stiffness = volume * (elastic.lambda + 2 * elastic.mu);
      for (std::size_t k = 0; k < shape.size(); ++k) {
        nodes_.internal[shape.node[k]] += pull * shape.G[k];
        nodes_.stiffness[shape.node[k]] += stiffness * shape.G[k].squaredNorm();
      }
    };
    if (!taylor && modes == 0) {
      const Vector<D> v = particles.v[p];
      return spread([&](std::size_t) -> const Vector<D>& { return v; });
    }
    scratch.velocity.assign(shape.size(), particles.v[p]);
    if (taylor)
      for (std::size_t k = 0; k < shape.size(); ++k)
        scratch.velocity[k] += particles.L[p] * (grid.position(shape.node[k]) - particles.x[p]);
    if constexpr (is_product<D, Shape>) {
      if (modes > 0) {
        scratch.modes.fill(grid, shape_of.functions.axes(grid, particles.x[p]), particles.x[p],
                           mode_set(method.velocity));
        scratch.modes.add_to(scratch.velocity, shape.size(), &particles.modes[p * modes], trusted);
      }
    }
    spread([&](std::size_t k) -> const Vector<D>& { return scratch.velocity[k]; });
  };
  scatter_by_rows<Scratch<D, Shape>>(particles.size(), problem_.threads, rows, add);

  typename Shape::template Nodes<D> shape;
  for (const Load<D>& load : problem_.loads) {
    const std::size_t p = load.particle;
    const Vector<D> force = force_of(load, particles, time_);
    shape_of.shape(grid, particles, p, shape);
    for (std::size_t k = 0; k < shape.size(); ++k)
      nodes_.force[shape.node[k]] += shape.S[k] * force;
  }
}

template <int D>
void Simulation<D>::correct_momentum() {
  const Particles<D>& particles = problem_.particles;
  Vector<D> missing = Vector<D>::Zero();
  double mass = 0;
  for (std::size_t p = 0; p < particles.size(); ++p) missing += particles.mass[p] * particles.v[p];
  for (std::size_t i = 0; i < nodes_.mass.size(); ++i) {
    missing -= nodes_.mass[i] * nodes_.mapped[i];
    mass += nodes_.mass[i];
  }
  for (std::size_t i = 0; i < nodes_.mass.size(); ++i)
    if (nodes_.mass[i] != 0) nodes_.mapped[i] += missing / mass;
}

template <int D>
void Simulation<D>::hold_boundaries() {
  for (const HeldVelocity& held : held_) {
    nodes_.velocity[held.node][held.axis] = held.velocity;
    nodes_.acceleration[held.node][held.axis] = 0;
  }
}

// sum_{j < m} (1 - S+ S)^j of a velocity, zero where one is held for j > 0.
template <int D>
std::vector<Vector<D>> Simulation<D>::filtered(std::vector<Vector<D>> velocity) const {
  const Particles<D>& particles = problem_.particles;
  const Grid<D>& grid = problem_.grid;
  std::vector<Vector<D>> left = velocity, back(velocity.size()), seen(particles.size());
  for (int j = 1; j < problem_.method.order; ++j) {
    std::fill(back.begin(), back.end(), Vector<D>::Zero());
    with_shape(problem_.method, [&](auto shape_of) {
      using Seen = typename decltype(shape_of)::template Nodes<D>;
      parallel_blocks(particles.size(), particles_per_block, problem_.threads,
                      [&](std::size_t begin, std::size_t end) {
                        Seen shape;
                        for (std::size_t p = begin; p < end; ++p) {
                          shape_of.shape(grid, particles, p, shape);
                          seen[p] = shape.value(left, trusted);
                        }
                      });
      const auto rows = [&](std::size_t p) {
        return shape_of.nodes_along(grid, particles, p, D - 1);
      };
      scatter_by_rows<Seen>(particles.size(), problem_.threads, rows,
                            [&](std::size_t p, Seen& shape) {
                              shape_of.shape(grid, particles, p, shape);
                              for (std::size_t k = 0; k < shape.size(); ++k)
                                back[shape.node[k]] += shape.S[k] * particles.mass[p] * seen[p];
                            });
    });
    for (std::size_t i = 0; i < left.size(); ++i)
      if (nodes_.mass[i] != 0) left[i] -= back[i] / nodes_.mass[i];
    for (const HeldVelocity& held : held_) left[held.node][held.axis] = 0;
    for (std::size_t i = 0; i < left.size(); ++i) velocity[i] += left[i];
  }
  return velocity;
}

// The nodes' velocities of which L is made, where some have a mass that is too small for the step;
// empty where none has.
template <int D>
std::vector<Vector<D>> Simulation<D>::limited(double dt, double kick) const {
  std::vector<Vector<D>> velocity;
  double heaviest = 0;
  for (const double mass : nodes_.mass) heaviest = std::max(heaviest, std::abs(mass));
  for (std::size_t i = 0; i < nodes_.stiffness.size(); ++i) {
    const double mass = std::abs(nodes_.mass[i]);
    const double strained = kick * dt * nodes_.stiffness[i];
    const bool feels_forces = mass > lightest_node * heaviest;
    if (!feels_forces || mass > light_node * heaviest || strained <= most_strained * mass) continue;
    if (velocity.empty()) velocity = nodes_.velocity;
    velocity[i] -=
        (1 - most_strained * mass / strained) * kick / nodes_.mass[i] * nodes_.internal[i];
  }
  if (!velocity.empty())
    for (const HeldVelocity& held : held_) velocity[held.node][held.axis] = held.velocity;
  return velocity;
}

// Steps 2 and 3: the momentum equation on the nodes, and what follows for the particles.
template <int D>
void Simulation<D>::advance(double dt) {
  const Update update = problem_.method.update;
  if (update == Update::runge_kutta) {
    advance_runge_kutta(dt);
  } else {
    const double kick = (last_dt_ + dt) / 2;
    const auto accelerate = [&](std::vector<Vector<D>>& velocity) {
      for (std::size_t i = 0; i < velocity.size(); ++i)
        velocity[i] += kick * nodes_.acceleration[i];
    };
    std::vector<Vector<D>> smooth;  // of xpic, whose L is that of the nodes themselves
    if (update == Update::xpic) {
      smooth = filtered(nodes_.velocity);
      accelerate(smooth);
    }
    accelerate(nodes_.velocity);
    if (update == Update::fmpm) nodes_.velocity = filtered(std::move(nodes_.velocity));
    const auto& carried = update == Update::xpic ? smooth : nodes_.velocity;
    const std::vector<Vector<D>> slower = limited(dt, kick);
    const auto& straining = slower.empty() ? nodes_.velocity : slower;
    with_shape(problem_.method,
               [&](auto shape_of) { gather(shape_of, carried, straining, dt, kick); });
  }
  time_ += dt;
  last_dt_ = dt;
  ++steps_;
  if (problem_.method.stress == StressUpdate::first) strain_by_map();
}

// The strain of the step just made, by the velocity that its particles show to the nodes now.
template <int D>
void Simulation<D>::strain_by_map() {
  fill_nodes();
  const Particles<D>& particles = problem_.particles;
  with_shape(problem_.method, [&](auto shape_of) {
    typename decltype(shape_of)::template Nodes<D> shape;
    for (std::size_t p = 0; p < particles.size(); ++p) {
      shape_of.shape(problem_.grid, particles, p, shape);
      const Matrix<D> L = shape.gradient(nodes_.velocity, trusted);
      strain(p, L, (Matrix<D>::Identity() + last_dt_ * L) * particles.F[p], last_dt_);
    }
  });
}

template <int D>
template <class Shape>
void Simulation<D>::gather(Shape shape_of, const std::vector<Vector<D>>& carried,
                           const std::vector<Vector<D>>& straining, double dt, double kick) {
  Particles<D>& particles = problem_.particles;
  const Grid<D>& grid = problem_.grid;
  const bool flip = problem_.method.update == Update::flip;
  const bool strains = problem_.method.stress == StressUpdate::last;
  [[maybe_unused]] const VelocityMap map = problem_.method.velocity;
  [[maybe_unused]] const auto modes = static_cast<std::size_t>(mode_count(map, D));
  parallel_blocks(particles.size(), particles_per_block, problem_.threads,
                  [&](std::size_t begin, std::size_t end) RECON_FLATTEN {
                    Scratch<D, Shape> scratch;
                    auto& shape = scratch.shape;
                    for (std::size_t p = begin; p < end; ++p) {
                      shape_of.shape(grid, particles, p, shape);
                      const Matrix<D> L = shape.gradient(straining, trusted);
                      const Vector<D> v = shape.value(carried, trusted);
                      if constexpr (is_product<D, Shape>) {
                        if (modes > 0) {
                          scratch.modes.fill(grid, shape_of.functions.axes(grid, particles.x[p]),
                                             particles.x[p], mode_set(map));
                          for (int r = 0; r < scratch.modes.count(); ++r)
                            particles.modes[p * modes + static_cast<std::size_t>(r)] =
                                scratch.modes.coefficient(r, shape, carried, trusted);
                        }
                      }
                      if (strains)
                        strain(p, L, (Matrix<D>::Identity() + dt * L) * particles.F[p], dt);
                      move(p, particles.x[p] + dt * v);
                      if (flip)
                        particles.v[p] += kick * shape.value(nodes_.acceleration, trusted);
                      else
                        particles.v[p] = v;
                      shape_of.move(grid, particles, p, carried, dt);
                      move(p, particles.x[p]);  // cpdi2 has put it elsewhere
                    }
                  });
}

// A particle comes to x, or to the wall that it cannot pass.
template <int D>
void Simulation<D>::move(std::size_t p, const Vector<D>& to) {
  const Grid<D>& grid = problem_.grid;
  Vector<D> x = to;
  for (int d = 0; d < D; ++d) {
    const double lower = grid.lower()[d], upper = grid.upper(d), margin = put_back * grid.h();
    if (walls_[d][0] && x[d] < lower && x[d] > lower - margin) x[d] = lower;
    if (walls_[d][1] && x[d] > upper && x[d] < upper + margin) x[d] = upper;
  }
  if (!x.allFinite()) throw Failure(steps_, "particle", p, "its position is not finite");
  if (!grid.contains(x)) {
    std::string at;
    for (int d = 0; d < D; ++d) at += (d ? ", " : "") + brief(x[d], 9);
    throw Failure(steps_, "particle", p, "it left the grid at (" + at + ")");
  }
  problem_.particles.x[p] = x;
}

// And to the deformation F by the velocity gradient L.
template <int D>
void Simulation<D>::strain(std::size_t p, const Matrix<D>& L, const Matrix<D>& F, double dt) {
  Particles<D>& particles = problem_.particles;
  if (!(F.determinant() > 0))
    throw Failure(steps_, "particle", p,
                  "its volume is no longer positive (det F = " + brief(F.determinant()) + ")");
  particles.F[p] = F;
  particles.L[p] = L;
  std::visit(
      [&](const auto& material) {
        double density = particles.energy[p] / particles.volume0[p];
        material.update(F, L, dt, particles.stress[p], density);
        particles.energy[p] = density * particles.volume0[p];
      },
      problem_.materials[particles.body[p]]);
}

// y' = f(y) for position, velocity and deformation; f is map() and the rates of flip.
template <int D>
void Simulation<D>::advance_runge_kutta(double dt) {
  constexpr int stages = 4;
  constexpr double part[stages] = {0.5, 0.5, 1, 0}, weight[stages] = {1, 2, 2, 1};
  Particles<D>& particles = problem_.particles;
  const Particles<D> start = particles;
  const double time = time_;
  struct Rates {
    Vector<D> x = Vector<D>::Zero(), v = Vector<D>::Zero();
    Matrix<D> L = Matrix<D>::Zero(), F = Matrix<D>::Zero();
    void add(double factor, const Rates& other) {
      x += factor * other.x;
      v += factor * other.v;
      L += factor * other.L;
      F += factor * other.F;
    }
  };
  std::vector<Rates> sum(particles.size());
  for (int stage = 0; stage < stages; ++stage) {
    const bool last = stage + 1 == stages;
    with_shape(problem_.method, [&](auto shape_of) {
      using Seen = typename decltype(shape_of)::template Nodes<D>;
      parallel_blocks(particles.size(), particles_per_block, problem_.threads,
                      [&](std::size_t begin, std::size_t end) {
                        Seen shape;
                        for (std::size_t p = begin; p < end; ++p) {
                          shape_of.shape(problem_.grid, particles, p, shape);
                          Rates rates;
                          rates.x = shape.value(nodes_.velocity, trusted);
                          rates.v = shape.value(nodes_.acceleration, trusted);
                          rates.L = shape.gradient(nodes_.velocity, trusted);
                          rates.F = rates.L * particles.F[p];
                          sum[p].add(weight[stage] / 6, rates);
                          const Rates& to = last ? sum[p] : rates;
                          const double step = last ? dt : part[stage] * dt;
                          particles.stress[p] = start.stress[p];
                          particles.energy[p] = start.energy[p];
                          strain(p, to.L, start.F[p] + step * to.F, step);
                          move(p, start.x[p] + step * to.x);
                          particles.v[p] = start.v[p] + step * to.v;
                        }
                      });
    });
    if (last) break;
    time_ = time + part[stage] * dt;
    fill_nodes();
  }
  time_ = time;
}

template <int D>
void Simulation<D>::restore(Particles<D> particles, double time, std::int64_t steps,
                            double last_dt) {
  require(particles.size() == problem_.particles.size(), "particles of the restart",
          particles.size(), "must be as many as the problem has");
  problem_.validate(particles);
  require(particles.corners.size() == problem_.particles.corners.size(), "corners of the particles",
          particles.corners.size(), "must be those of the method for each particle");
  require(particles.modes.size() == problem_.particles.modes.size(), "modes of the particles",
          particles.modes.size(), "must be those of the method for each particle");
  require(std::isfinite(time) && time >= 0, "time of the restart", time,
          "must be finite and not negative");
  require(steps >= 0, "steps of the restart", steps, "must not be negative");
  require(std::isfinite(last_dt) && last_dt >= 0, "last step of the restart", last_dt,
          "must be finite and not negative");
  problem_.particles = std::move(particles);
  time_ = time;
  steps_ = steps;
  last_dt_ = last_dt;
  nodes_ = {};
  cells_ = {};
  nodes_state_ = NodesState::none;
  signs_.clear();
  negative_mass_.reset();
  sign_change_.reset();
}

template class Simulation<1>;
template class Simulation<2>;
template class Simulation<3>;

}  // namespace recon::mpm
