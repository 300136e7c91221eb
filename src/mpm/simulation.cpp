#include "recon/mpm/simulation.hpp"

#include <cmath>
#include <limits>

#include "mpm/cell_quadrature.hpp"
#include "mpm/scatter.hpp"
#include "mpm/velocity_fit.hpp"
#include "recon/core/parallel.hpp"

namespace recon::mpm {
namespace {

constexpr std::size_t particles_per_block = 1024;
constexpr std::size_t fewest_for_threads =
    2000;                                // a step of fewer is over before threads have started
constexpr double lightest_node = 1e-10;  // of the heaviest

}  // namespace

Failure::Failure(std::int64_t step, std::size_t particle, const std::string& what)
    : std::runtime_error("step " + std::to_string(step) + ", particle " + std::to_string(particle) +
                         ": " + what),
      step_(step),
      particle_(particle) {}

template <int D>
Simulation<D>::Simulation(Problem<D> problem) : problem_(std::move(problem)) {
  problem_.validate();
  Particles<D>& particles = problem_.particles;
  if (particles.size() < fewest_for_threads) problem_.threads = 1;
  if (problem_.method.domain == Domain::cpdi2 && particles.corners.empty())
    for (std::size_t p = 0; p < particles.size(); ++p)
      particles.corners.push_back(particles.domain(p));
}

template <int D>
Step Simulation<D>::choose_step() const {
  const TimeOptions& time = problem_.time;
  const Particles<D>& particles = problem_.particles;
  if (time.rule == StepRule::fixed) return {time.step, 0};
  Step slowest{std::numeric_limits<double>::infinity(), 0};
  for (std::size_t p = 0; p < particles.size(); ++p) {
    const Lame& elastic = lame(problem_.materials[particles.body[p]]);
    const double reference = particles.mass[p] / particles.volume0[p];
    const double speed = time.rule == StepRule::adaptive
                             ? elastic.p_wave_speed(particles.density(p)) + particles.v[p].norm()
                         : time.rule == StepRule::p_wave ? elastic.p_wave_speed(reference)
                                                         : elastic.bar_wave_speed(reference);
    const double dt = time.courant * problem_.grid.h() / speed;
    if (dt < slowest.dt) slowest = {dt, p};
  }
  return slowest;
}

// Step 1. What the papers call "map from material points to the grid".
template <int D>
void Simulation<D>::map() {
  const Particles<D>& particles = problem_.particles;
  acceleration_.assign(problem_.body_force ? particles.size() : 0, Vector<D>::Zero());
  if (problem_.body_force) problem_.body_force(particles, time_, problem_.threads, acceleration_);

  const std::size_t count = problem_.grid.size();
  nodes_.mass.assign(count, 0);
  nodes_.momentum.assign(count, Vector<D>::Zero());
  nodes_.force.assign(count, Vector<D>::Zero());
  with_domain(problem_.method.domain, [&](auto domain) { scatter(domain); });
  if (problem_.method.quadrature == Quadrature::cells) integrate_cells();

  const double heaviest = *std::max_element(nodes_.mass.begin(), nodes_.mass.end());
  nodes_.mapped.resize(count);
  nodes_.acceleration.resize(count);
  nodes_.unfitted = 0;
  for (std::size_t i = 0; i < count; ++i) {
    nodes_.mapped[i].setZero();
    nodes_.acceleration[i].setZero();
    if (!(nodes_.mass[i] > 0)) continue;
    nodes_.mapped[i] = nodes_.momentum[i] / nodes_.mass[i];
    nodes_.acceleration[i] = problem_.gravity;
    if (nodes_.mass[i] > lightest_node * heaviest)
      nodes_.acceleration[i] += nodes_.force[i] / nodes_.mass[i];
  }
  if (problem_.method.velocity != VelocityMap::mass_weighted) fit_velocity();
  nodes_.velocity = nodes_.mapped;
  hold_boundaries();
}

template <int D>
template <class DomainPolicy>
void Simulation<D>::scatter(DomainPolicy domain) {
  const Particles<D>& particles = problem_.particles;
  const Grid<D>& grid = problem_.grid;
  const bool particle_quadrature = problem_.method.quadrature == Quadrature::particles;
  const auto rows = [&](std::size_t p) {
    const double x = particles.x[p][D - 1], reach = domain.reach(particles, p, D - 1);
    return std::pair{grid.cell(x - reach, D - 1), grid.cell(x + reach, D - 1) + 1};
  };
  scatter_by_slabs<ShapeFunctions<D>>(
      particles.size(), problem_.threads, rows, [&](std::size_t p, ShapeFunctions<D>& shape) {
        const double volume = domain.shape(grid, particles, p, shape);
        const double mass = particles.mass[p];
        const Vector<D> momentum = mass * particles.v[p];
        if (particle_quadrature) {
          const Matrix<D> pull = -volume * particles.stress[p];
          const Vector<D> push =
              acceleration_.empty() ? Vector<D>::Zero() : Vector<D>(mass * acceleration_[p]);
          for (std::size_t k = 0; k < shape.size(); ++k) {
            const std::uint32_t i = shape.node[k];
            nodes_.mass[i] += shape.S[k] * mass;
            nodes_.momentum[i] += shape.S[k] * momentum;
            nodes_.force[i] += pull * shape.G[k] + shape.S[k] * push;
          }
        } else {
          for (std::size_t k = 0; k < shape.size(); ++k) {
            nodes_.momentum[shape.node[k]] += shape.S[k] * momentum;
          }
        }
      });

  ShapeFunctions<D> shape;
  for (const Load<D>& load : problem_.loads) {
    const std::size_t p = load.particle;
    const Matrix<D>& F = particles.F[p];
    const double magnitude = load.magnitude(time_);
    const Vector<D> follower = F.determinant() * (F.inverse().transpose() * load.area);
    const Vector<D> force = magnitude * (load.direction - follower);
    domain.shape(grid, particles, p, shape);
    for (std::size_t k = 0; k < shape.size(); ++k)
      nodes_.force[shape.node[k]] += shape.S[k] * force;
  }
}

template <int D>
void Simulation<D>::integrate_cells() {
  fit_cells(problem_, acceleration_, cells_);
  mpm::integrate_cells(problem_.grid, cells_, nodes_);
}

template <int D>
void Simulation<D>::fit_velocity() {
  const Particles<D>& particles = problem_.particles;
  mpm::fit_velocity(problem_, nodes_);
  if (!problem_.method.momentum_correction) return;
  Vector<D> missing = Vector<D>::Zero();
  double mass = 0;
  for (std::size_t p = 0; p < particles.size(); ++p) missing += particles.mass[p] * particles.v[p];
  for (std::size_t i = 0; i < nodes_.mass.size(); ++i) {
    missing -= nodes_.mass[i] * nodes_.mapped[i];
    mass += nodes_.mass[i];
  }
  for (std::size_t i = 0; i < nodes_.mass.size(); ++i)
    if (nodes_.mass[i] > 0) nodes_.mapped[i] += missing / mass;
}

template <int D>
void Simulation<D>::hold_boundaries() {
  const Grid<D>& grid = problem_.grid;
  for (const Boundary<D>& boundary : problem_.boundaries) {
    const auto plane = static_cast<std::size_t>(
        std::lround((boundary.at - grid.lower()[boundary.axis]) / grid.h()));
    for (std::size_t i = 0; i < grid.size(); ++i) {
      if (grid.nodes().index(i)[boundary.axis] != plane) continue;
      for (int d = 0; d < D; ++d) {
        if (!boundary.velocity[d]) continue;
        nodes_.velocity[i][d] = *boundary.velocity[d];
        nodes_.acceleration[i][d] = 0;
      }
    }
  }
}

// Steps 2 and 3: the momentum equation on the nodes, and what follows for the particles.
template <int D>
void Simulation<D>::advance(double dt) {
  require(dt > 0 && std::isfinite(dt), "time step", dt, "must be positive and finite");
  const double kick = (last_dt_ + dt) / 2;
  for (std::size_t i = 0; i < nodes_.velocity.size(); ++i)
    nodes_.velocity[i] += kick * nodes_.acceleration[i];
  with_domain(problem_.method.domain, [&](auto domain) { gather(domain, dt, kick); });
  time_ += dt;
  last_dt_ = dt;
  ++steps_;
}

template <int D>
template <class DomainPolicy>
void Simulation<D>::gather(DomainPolicy domain, double dt, double kick) {
  Particles<D>& particles = problem_.particles;
  const Grid<D>& grid = problem_.grid;
  parallel_blocks(particles.size(), particles_per_block, problem_.threads,
                  [&](std::size_t begin, std::size_t end) {
                    ShapeFunctions<D> shape;
                    for (std::size_t p = begin; p < end; ++p) {
                      domain.shape(grid, particles, p, shape);
                      const Matrix<D> L = shape.gradient(nodes_.velocity);
                      const Matrix<D> F = (Matrix<D>::Identity() + dt * L) * particles.F[p];
                      const Vector<D> x = particles.x[p] + dt * shape.value(nodes_.velocity);
                      if (!(F.determinant() > 0))
                        throw Failure(steps_, p,
                                      "its volume is no longer positive (det F = " +
                                          recon::detail::to_text(F.determinant()) + ")");
                      if (!x.allFinite()) throw Failure(steps_, p, "its position is not finite");
                      if (!grid.contains(x)) {
                        std::string at;
                        for (int d = 0; d < D; ++d)
                          at += (d ? ", " : "") + recon::detail::to_text(x[d]);
                        throw Failure(steps_, p, "it left the grid at (" + at + ")");
                      }
                      particles.v[p] += kick * shape.value(nodes_.acceleration);
                      particles.x[p] = x;
                      particles.F[p] = F;
                      particles.L[p] = L;
                      std::visit(
                          [&](const auto& material) {
                            double density = particles.energy[p] / particles.volume0[p];
                            material.update(F, L, dt, particles.stress[p], density);
                            particles.energy[p] = density * particles.volume0[p];
                          },
                          problem_.materials[particles.body[p]]);
                      domain.move(grid, particles, p, nodes_.velocity, dt);
                    }
                  });
}

template <int D>
void Simulation<D>::restore(Particles<D> particles, double time, std::int64_t steps,
                            double last_dt) {
  require(particles.size() == problem_.particles.size(), "particles of the restart",
          particles.size(), "must be as many as the problem has");
  problem_.particles = std::move(particles);
  time_ = time;
  steps_ = steps;
  last_dt_ = last_dt;
}

template class Simulation<1>;
template class Simulation<2>;
template class Simulation<3>;

}  // namespace recon::mpm
