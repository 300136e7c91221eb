// Momenta, energies and fields of one run over time.
#include <algorithm>
#include <cmath>

#include "measure.hpp"
#include "programs/common/text.hpp"
#include "recon/operators/reconstruct.hpp"
#include "recon/points/generate.hpp"
#include "recon/studies/errors.hpp"

namespace recon::program {
namespace {

struct Energies {
  double kinetic = 0, strain = 0;
  double total() const { return kinetic + strain; }
};

// Of the exact motion, at the particles' first places.
template <int D>
Energies exact_energies(const mpm::Simulation<D>& simulation, const mpm::Manufactured<D>& exact) {
  const mpm::Particles<D>& particles = simulation.particles();
  const auto& material = mpm::material_of_exact(simulation.problem().materials);
  Energies sum;
  for (std::size_t p = 0; p < particles.size(); ++p) {
    const auto state = exact.at(particles.X[p], simulation.time());
    mpm::Matrix<D> stress;
    double energy = 0;
    material.update(state.F, state.velocity_gradient, 0, stress, energy);
    sum.kinetic += particles.mass[p] * state.velocity.squaredNorm() / 2;
    sum.strain += particles.volume0[p] * energy;
  }
  return sum;
}

template <int D>
double moment(const mpm::Vector<D>& x, const mpm::Vector<D>& p) {
  if constexpr (D == 1) return 0;
  if constexpr (D == 2) return std::abs(x[0] * p[1] - x[1] * p[0]);
  if constexpr (D == 3)
    return std::hypot(x[1] * p[2] - x[2] * p[1], x[2] * p[0] - x[0] * p[2],
                      x[0] * p[1] - x[1] * p[0]);
}

// Sums over particles and over nodes, over time.
struct History {
  std::vector<double> time, sum_of_particles, sum_of_nodes;
  std::vector<Energies> energies, exact;
  std::vector<mpm::Ledger> ledger;
  double largest_moment = 0;  // sum of |x x m v| of the particles
};

double most(const std::vector<double>& values) {
  return *std::max_element(values.begin(), values.end());
}

template <int D>
History watch(const mpm::ProblemFile<D>& file, mpm::Simulation<D>& simulation, Measured& measured) {
  History history;
  std::optional<mpm::Ledger> start;
  measured.note = run_to_end(simulation, file, [&] {
    const mpm::Ledger now = mpm::account(simulation, start);
    if (!start) start = now;
    const auto& particles = simulation.particles();
    const auto& nodes = simulation.nodes();
    double of_particles = 0, of_nodes = 0, moments = 0;
    for (std::size_t p = 0; p < particles.size(); ++p) {
      of_particles += particles.mass[p] * particles.v[p].norm();
      moments += moment<D>(particles.x[p], particles.mass[p] * particles.v[p]);
    }
    for (std::size_t i = 0; i < nodes.mass.size(); ++i)
      of_nodes += std::abs(nodes.mass[i]) * nodes.mapped[i].norm();
    history.time.push_back(now.time);
    history.sum_of_particles.push_back(of_particles);
    history.sum_of_nodes.push_back(of_nodes);
    history.energies.push_back({now.kinetic, now.strain});
    if (file.exact) history.exact.push_back(exact_energies(simulation, *file.exact));
    history.ledger.push_back(now);
    history.largest_moment = std::max(history.largest_moment, moments);
  });
  return history;
}

void draw_energies(const Request& request, const History& history) {
  LinePlot plot;
  plot.title = "energies of " + request.method + ", " + std::to_string(request.grid) + " cells";
  plot.x_label = "time";
  plot.y_label = "energy";
  const auto add = [&](const std::string& name, const std::vector<Energies>& from, auto value) {
    Curve curve{name, history.time, {}, CurveStyle::line};
    for (const Energies& each : from) curve.y.push_back(value(each));
    plot.curves.push_back(std::move(curve));
  };
  const auto kinetic = [](const Energies& e) { return e.kinetic; };
  const auto strain = [](const Energies& e) { return e.strain; };
  const auto total = [](const Energies& e) { return e.total(); };
  add("kinetic", history.energies, kinetic);
  add("strain", history.energies, strain);
  add("total", history.energies, total);
  if (!history.exact.empty()) {
    add("kinetic, exact", history.exact, kinetic);
    add("strain, exact", history.exact, strain);
    add("total, exact", history.exact, total);
  }
  request.draw(plot, "energy");
}

void add_momenta(Measured& measured, const History& history) {
  const double size = most(history.sum_of_particles);
  double sums = 0, vectors = 0, angular = 0;
  for (std::size_t k = 0; k < history.time.size(); ++k) {
    const mpm::Ledger& now = history.ledger[k];
    sums = std::max(sums, std::abs(history.sum_of_nodes[k] - history.sum_of_particles[k]));
    vectors = std::max(vectors, mpm::distance(now.momentum, now.node_momentum));
    angular = std::max(angular, mpm::distance(now.angular, now.node_angular));
  }
  measured.add("defect of sum m |v|", sums / size);
  measured.add("momentum defect", vectors / size);
  if (history.largest_moment > 0)
    measured.add("angular momentum defect", angular / history.largest_moment);
  measured.add(
      "change of momentum",
      mpm::distance(history.ledger.back().momentum, history.ledger.front().momentum) / size);
}

void add_energies(Measured& measured, const History& history) {
  double kinetic = 0, strain = 0, total = 0;
  for (const Energies& each : history.energies) {
    kinetic = std::max(kinetic, each.kinetic);
    strain = std::max(strain, each.strain);
    total = std::max(total, each.total());
  }
  measured.add("largest kinetic energy", kinetic);
  measured.add("largest strain energy", strain);
  measured.add("largest total energy", total);
  if (history.exact.empty()) {
    const double first = history.energies.front().total();
    measured.add("change of total energy", history.energies.back().total() / first - 1);
    return;
  }
  double largest = 0, off_kinetic = 0, off_strain = 0, off_total = 0;
  for (std::size_t k = 0; k < history.exact.size(); ++k) {
    const Energies &is = history.energies[k], &should = history.exact[k];
    largest = std::max(largest, should.total());
    off_kinetic = std::max(off_kinetic, std::abs(is.kinetic - should.kinetic));
    off_strain = std::max(off_strain, std::abs(is.strain - should.strain));
    off_total = std::max(off_total, std::abs(is.total() - should.total()));
  }
  measured.add("largest total energy over the exact one", total / largest);
  measured.add("error of the kinetic energy", off_kinetic / largest);
  measured.add("error of the strain energy", off_strain / largest);
  measured.add("error of the total energy", off_total / largest);
}

// Defects of the map are the largest over time, over the largest sum of m |v| or of |x x m v| of
// the particles. Errors of energies are over the largest exact total.
Measured account(const Request& request) {
  Measured measured;
  std::visit(
      [&]<int D>(const mpm::ProblemFile<D>& file) {
        mpm::Simulation<D> simulation(file.problem);
        const History history = watch(file, simulation, measured);
        if (!measured.note.empty()) return;
        add_momenta(measured, history);
        add_energies(measured, history);
        if (file.exact && history.largest_moment > 0)
          measured.add("angular momentum at the end less the exact one",
                       (history.ledger.back().angular[2] -
                        exact_angular_momentum(simulation, *file.exact)[2]) /
                           history.largest_moment);
        draw_energies(request, history);
      },
      request.load());
  return measured;
}

// Energies are parts of the first total; the rebound is that of the first body.
Measured impact(const Request& request) {
  Measured measured;
  std::visit(
      [&]<int D>(const mpm::ProblemFile<D>& file) {
        mpm::Simulation<D> simulation(file.problem);
        const auto velocity = [&] {
          mpm::Vector<D> sum = mpm::Vector<D>::Zero();
          double mass = 0;
          const auto& particles = simulation.particles();
          for (std::size_t p = 0; p < particles.size(); ++p)
            if (particles.body[p] == 0) {
              sum += particles.mass[p] * particles.v[p];
              mass += particles.mass[p];
            }
          return mpm::Vector<D>(sum / mass);
        };
        const mpm::Vector<D> before = velocity();
        const History history = watch(file, simulation, measured);
        if (!measured.note.empty()) return;
        const double first = history.energies.front().total();
        double least = first, strain = 0;
        for (const Energies& each : history.energies) {
          least = std::min(least, each.total());
          strain = std::max(strain, each.strain);
        }
        const Energies& last = history.energies.back();
        measured.add("speed of the rebound", -velocity().dot(before) / before.squaredNorm());
        measured.add("kinetic energy at the end", last.kinetic / first);
        measured.add("strain energy at the end over its largest", last.strain / strain);
        measured.add("total energy at the end", last.total() / first);
        measured.add("least total energy", least / first);
        measured.add("energy lost", 1 - last.total() / first);
        add_momenta(measured, history);
        draw_energies(request, history);
      },
      request.load());
  return measured;
}

// The sizes of errors at the particles, spread over a fine grid by Shepard's mean.
HeatMap error_map(const std::string& quantity, const mpm::Simulation<2>& simulation,
                  const std::vector<double>& sizes) {
  HeatMap map;
  map.colour_label = quantity + " error";
  HeatMapPanel panel;
  panel.title = simulation.problem().method.name;
  const double h = simulation.problem().grid.h();
  const auto points = points_of(simulation.particles().x);
  panel.grid = covering_grid(bounding_box(points, "particles"), h / 6);
  const auto nodes = panel.grid.nodes();
  const Reconstruction fit =
      reconstruct(points, nodes.view(), {.degree = 0, .neighbours = Radius{0.45 * h}});
  panel.values.resize(panel.grid.size());
  fit.apply(field_of(sizes), field_of(panel.values));
  for (const auto& x : simulation.particles().x) panel.dots.push_back({x[0], x[1]});
  map.panels.push_back(std::move(panel));
  return map;
}

double rms(const std::vector<double>& values) {
  double sum = 0;
  for (const double each : values) sum += each * each;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

// Errors at the end in a ring around the origin: in its innermost, middle and outermost fifth.
Measured ring_fields(const Request& request) {
  Measured measured;
  const auto file = std::get<mpm::ProblemFile<2>>(request.load());
  mpm::Simulation<2> simulation(file.problem);
  measured.note = run_to_end(simulation, file);
  if (!measured.note.empty()) return measured;
  const mpm::Particles<2>& particles = simulation.particles();
  double inner = 1e300, outer = 0;
  for (const auto& X : particles.X) {
    inner = std::min(inner, X.norm());
    outer = std::max(outer, X.norm());
  }
  for (const std::string quantity : {"displacement", "velocity", "stress"}) {
    std::vector<double> sizes;
    std::vector<double> zones[3];
    for (std::size_t p = 0; p < particles.size(); ++p) {
      sizes.push_back(mpm::error_of(simulation, *file.exact, p, quantity));
      const double place = (particles.X[p].norm() - inner) / (outer - inner);
      const int fifth = std::min(4, static_cast<int>(5 * place));
      if (fifth % 2 == 0) zones[fifth / 2].push_back(sizes.back());
    }
    measured.add("largest " + quantity + " error", most(sizes));
    measured.add("rms " + quantity + " error", rms(sizes));
    measured.add(quantity + " error, inner", rms(zones[0]));
    measured.add(quantity + " error, middle", rms(zones[1]));
    measured.add(quantity + " error, outer", rms(zones[2]));
    if (quantity == "displacement")
      measured.add("displacement over the width", rms(sizes) / (outer - inner));
    if (!request.folder.empty()) request.draw(error_map(quantity, simulation, sizes), quantity);
  }
  return measured;
}

}  // namespace

std::span<const NamedMeasure> account_measures() {
  static constexpr NamedMeasure all[] = {
      {"account", account}, {"impact", impact}, {"ring fields", ring_fields}};
  return all;
}

}  // namespace recon::program
