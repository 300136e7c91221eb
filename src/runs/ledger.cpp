#include "recon/runs/ledger.hpp"

#include <charconv>
#include <limits>

#include "mpm/modes.hpp"
#include "mpm/policies.hpp"
#include "runs/angular.hpp"

namespace recon::mpm {
namespace {

constexpr std::size_t particles_per_sum = 4096;

template <int D>
void add(std::array<double, 3>& sum, const Vector<D>& value) {
  for (int d = 0; d < D; ++d) sum[d] += value[d];
}

// V sigma : epsilon / 2 with epsilon the strain that goes with sigma by Hooke's law in plane
// strain.
template <int D>
double linear_strain_energy(const Lame& elastic, const Matrix<D>& stress, double volume) {
  const double trace = stress.trace();
  const double compressed = elastic.lambda / (D * elastic.lambda + 2 * elastic.mu) * trace;
  return volume * (stress.squaredNorm() - compressed * trace) / (4 * elastic.mu);
}

void add(std::array<double, 3>& sum, const std::array<double, 3>& value) {
  for (int d = 0; d < 3; ++d) sum[d] += value[d];
}

// The nodes of negative mass in a part of a state; one of several parts counts once in all of them.
template <int D>
double negative_share(const Nodes<D>& nodes) {
  double sum = 0;
  if (nodes.negative > 0)
    for (std::size_t i = 0; i < nodes.mass.size(); ++i)
      if (nodes.mass[i] < -lightest_node * nodes.heaviest()) sum += nodes.share_of(i);
  return sum;
}

}  // namespace

template <int D>
Ledger account(const Simulation<D>& simulation, const std::optional<Ledger>& start,
               const std::optional<Ledger>& before) {
  const View<D> view(simulation);
  view.require_mapped("account");
  return account(view, external_forces(view), start, before);
}

template <int D>
Ledger account(const View<D>& view, const ExternalForces<D>& forces,
               const std::optional<Ledger>& start, const std::optional<Ledger>& before) {
  view.require_mapped("account");
  Ledger sums = sums_of(view.state(), view.step());
  if (!view.is_whole()) {
    double negative = negative_share(view.nodes());
    std::vector<double> each;
    const auto all_sums = [&](const auto& field) {
      for (double* one : {&sums.mass, &sums.node_mass, &sums.kinetic, &sums.node_kinetic,
                          &sums.strain, &sums.linear_strain, &sums.power, &negative})
        field(*one);
      for (auto* three : {&sums.momentum, &sums.node_momentum, &sums.angular, &sums.node_angular})
        for (double& one : *three) field(one);
    };
    all_sums([&](double& one) { each.push_back(one); });
    view.sum(each);
    std::size_t next = 0;
    all_sums([&](double& one) { one = each[next++]; });
    sums.negative_nodes = static_cast<std::size_t>(std::llround(negative));
  }
  return account(sums, forces.power, start, before);
}

template <int D>
Ledger sums_of(const State<D>& s, const Step<D>& step) {
  const Problem<D>& problem = step.problem();
  const Particles<D>& particles = s.particles;
  const Nodes<D>& nodes = step.nodes();
  const double half = problem.method.velocity_lag(s.last_dt);

  const VelocityMap map = problem.method.velocity;
  const std::size_t modes = mode_count(map, D);
  const std::vector<Vector<D>>& body_force = step.body_force();

  // Sums of blocks, added in their order.
  std::vector<Ledger> blocks((s.own() + particles_per_sum - 1) / particles_per_sum);
  with_shape(problem.method, [&](auto shape_of) {
    parallel_blocks(
        s.own(), particles_per_sum, problem.threads, [&](std::size_t begin, std::size_t end) {
          Ledger& sum = blocks[begin / particles_per_sum];
          typename decltype(shape_of)::template Nodes<D> shape, at;
          ParticleModes<D, decltype(shape_of)> of;
          for (std::size_t p = begin; p < end; ++p) {
            shape_of.shape(nodes.grid, particles, p, shape);
            // What the particle takes from the nodes.
            Vector<D> velocity = shape.value(nodes.velocity, trusted);
            Vector<D> acceleration = shape.value(nodes.acceleration, trusted);
            const auto see_image = [&](const Image<D>& image, std::size_t i) {
              functions_of(nodes.images.particles, nodes, shape_of, i, at);
              velocity += image.vector(at.value(nodes.velocity, trusted));
              acceleration += image.vector(at.value(nodes.acceleration, trusted));
            };
            const int more = for_mirrors(problem, nodes, particles.x[p], p, see_image);
            if (more > 0) {
              velocity /= 1 + more;
              acceleration /= 1 + more;
            }
            const double m = particles.mass[p];
            const Vector<D> momentum = m * particles.v[p];
            const Vector<D> gained = half * acceleration;
            const Vector<D> now = particles.v[p] + gained;
            Vector<D> weight = m * problem.gravity;
            if (!body_force.empty()) weight += m * body_force[p];
            sum.power += weight.dot(velocity + gained);
            sum.mass += m;
            add<D>(sum.momentum, momentum);
            add_angular<D>(sum.angular, particles.x[p], momentum);
            if (modes > 0) {
              fill_modes(nodes.grid, shape_of, particles.x[p], shape, map, of);
              const Matrix<D> moment = m * of.moment(&particles.modes[p * modes]);
              for (int d = 0; d < D; ++d)
                add_angular<D>(sum.angular, Vector<D>::Unit(d), moment.col(d));
            }
            sum.kinetic += m * now.squaredNorm() / 2;
            sum.strain += particles.energy[p];
            sum.linear_strain += linear_strain_energy(lame(problem.materials[particles.body[p]]),
                                                      particles.stress[p], particles.volume(p));
          }
        });
  });
  Ledger ledger;
  ledger.step = s.steps;
  ledger.time = s.time;
  for (const Ledger& block : blocks) {
    ledger.mass += block.mass;
    add(ledger.momentum, block.momentum);
    add(ledger.angular, block.angular);
    ledger.kinetic += block.kinetic;
    ledger.strain += block.strain;
    ledger.power += block.power;
    ledger.linear_strain += block.linear_strain;
  }
  std::vector<Vector<D>> now = nodes.velocity;
  for (std::size_t i = 0; i < now.size(); ++i) now[i] += half * nodes.acceleration[i];
  const std::vector<Vector<D>> mapped_momentum = nodes.times_mass(nodes.mapped);
  const std::vector<Vector<D>> momentum_now = nodes.times_mass(now);
  for (std::size_t i = 0; i < nodes.mass.size(); ++i) {
    const double share = nodes.share_of(i);
    const Vector<D> own = share * mapped_momentum[i];
    ledger.node_mass += share * nodes.mass[i];
    add<D>(ledger.node_momentum, own);
    add_angular<D>(ledger.node_angular, nodes.grid.position(i), own);
    ledger.node_kinetic += share * momentum_now[i].dot(now[i]) / 2;
  }
  ledger.negative_nodes = nodes.negative;
  return ledger;
}

Ledger account(const Ledger& sums, double power, const std::optional<Ledger>& start,
               const std::optional<Ledger>& before) {
  Ledger ledger = sums;
  ledger.interpolation_error = ledger.node_kinetic - ledger.kinetic;
  ledger.algorithmic_error = -(ledger.node_kinetic + ledger.strain);
  const Ledger& from = start ? *start : ledger;
  ledger.interpolation_error -= from.node_kinetic - from.kinetic;
  ledger.algorithmic_error += from.node_kinetic + from.strain;
  ledger.power += power;
  if (before)
    ledger.work = before->work + (ledger.time - before->time) * (before->power + ledger.power) / 2;
  else if (start)
    ledger.work = std::numeric_limits<double>::quiet_NaN();
  return ledger;
}

std::string ledger_header() {
  return "step,time,mass,node_mass,momentum_x,momentum_y,momentum_z,node_momentum_x,node_momentum_"
         "y,"
         "node_momentum_z,angular_x,angular_y,angular_z,node_angular_x,node_angular_y,node_angular_"
         "z,"
         "kinetic,node_kinetic,strain,total,interpolation_error,algorithmic_error,linear_strain,"
         "negative_nodes,power,work,balance";
}

std::string ledger_row(const Ledger& ledger) {
  std::string row = std::to_string(ledger.step);
  const auto put = [&](double value) {
    char text[32];
    const auto end = std::to_chars(text, text + sizeof text, value);
    row.append(",").append(text, end.ptr);
  };
  put(ledger.time);
  put(ledger.mass);
  put(ledger.node_mass);
  for (const auto* each :
       {&ledger.momentum, &ledger.node_momentum, &ledger.angular, &ledger.node_angular})
    for (const double value : *each) put(value);
  for (const double value :
       {ledger.kinetic, ledger.node_kinetic, ledger.strain, ledger.total(),
        ledger.interpolation_error, ledger.algorithmic_error, ledger.linear_strain,
        static_cast<double>(ledger.negative_nodes), ledger.power, ledger.work, ledger.balance()})
    put(value);
  return row;
}

#define RECON_INSTANTIATE(D)                                                                      \
  template Ledger account(const Simulation<D>&, const std::optional<Ledger>&,                     \
                          const std::optional<Ledger>&);                                          \
  template Ledger sums_of(const State<D>&, const Step<D>&);                                       \
  template Ledger account(const View<D>&, const ExternalForces<D>&, const std::optional<Ledger>&, \
                          const std::optional<Ledger>&);
RECON_INSTANTIATE(1)
RECON_INSTANTIATE(2)
RECON_INSTANTIATE(3)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
