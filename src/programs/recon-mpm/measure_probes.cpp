// Numbers at places and times of a run, as the list of claims asks for them: benchmarks.
#include <algorithm>
#include <cmath>

#include "measure.hpp"
#include "recon/core/error.hpp"
#include "recon/operators/reconstruct.hpp"

namespace recon::program {
namespace {

// A quantity over time.
struct Trace {
  std::vector<double> time, value;

  double at(double t) const {
    const auto after = std::lower_bound(time.begin(), time.end(), t);
    if (after == time.begin()) return value.front();
    if (after == time.end()) return value.back();
    const auto k = static_cast<std::size_t>(after - time.begin());
    const double part = (t - time[k - 1]) / (time[k] - time[k - 1]);
    return value[k - 1] + part * (value[k] - value[k - 1]);
  }
};

int axis_of(const Probe& probe, std::size_t letter, int dimension) {
  const int axis = letter < probe.component.size() ? probe.component[letter] - 'x' : -1;
  if (axis < 0 || axis >= dimension)
    recon::detail::throw_invalid("component of the probe", probe.name,
                                 "must be of the problem's axes");
  return axis;
}

// One probe of a run.
template <int D>
class Gauge {
 public:
  Gauge(const Probe& probe, const mpm::Simulation<D>& simulation) : probe_(&probe) {
    const mpm::Particles<D>& particles = simulation.particles();
    if (is_field()) axes_ = {axis_of(probe, 0, D), probe.of == "stress" ? axis_of(probe, 1, D) : 0};
    if (probe.of == "front") axes_[0] = axis_of(probe, 0, D);
    if (!is_field()) return;
    weights_.assign(particles.size(), 0);
    if (probe.at.empty()) {  // the mean over the mass
      double mass = 0;
      for (std::size_t p = 0; p < particles.size(); ++p)
        if (counts(particles, p)) mass += weights_[p] = particles.mass[p];
      for (double& each : weights_) each /= mass;
      return;
    }
    if (probe.at.size() != D)
      recon::detail::throw_invalid("place of the probe", probe.name,
                                   "must have a number for each axis");
    mpm::Vector<D> place;
    for (int d = 0; d < D; ++d) place[d] = probe.at[static_cast<std::size_t>(d)];
    const std::vector<mpm::Vector<D>> places{place};
    const Reconstruction fit =
        reconstruct(points_of(particles.X), points_of(places),
                    {.degree = 1, .neighbours = Radius{1.6 * simulation.problem().grid.h()}});
    const std::vector<double> one{1};
    const auto row = fit.apply_transpose(field_of(one));
    for (std::size_t p = 0; p < particles.size(); ++p)
      weights_[p] = row(static_cast<Eigen::Index>(p), 0);
  }

  bool needs_account() const { return !is_field() && probe_->of != "front"; }

  void read(const mpm::Simulation<D>& simulation, const mpm::Ledger& ledger) {
    trace_.time.push_back(simulation.time());
    trace_.value.push_back(value(simulation.particles(), ledger));
  }

  // NaN where the run has not come to the end of the probe's time.
  double result(bool finished) const {
    const double last = trace_.time.back(), until = std::min(probe_->until, last);
    if (!finished && probe_->until > last) return std::numeric_limits<double>::quiet_NaN();
    if (probe_->take == "end") return trace_.at(until);
    Trace part;
    for (std::size_t k = 0; k < trace_.time.size(); ++k)
      if (trace_.time[k] >= probe_->from && trace_.time[k] <= until) {
        part.time.push_back(trace_.time[k]);
        part.value.push_back(trace_.value[k]);
      }
    if (part.time.size() < 2) return std::numeric_limits<double>::quiet_NaN();
    const auto least = std::min_element(part.value.begin(), part.value.end());
    const auto greatest = std::max_element(part.value.begin(), part.value.end());
    const auto time = [&](auto at) {
      return part.time[static_cast<std::size_t>(at - part.value.begin())];
    };
    if (probe_->take == "least") return *least;
    if (probe_->take == "greatest") return *greatest;
    if (probe_->take == "time of least") return time(least);
    if (probe_->take == "time of greatest") return time(greatest);
    if (probe_->take == "change") return part.value.back() / part.value.front() - 1;
    if (probe_->take == "time above") {
      for (std::size_t k = 0; k < part.time.size(); ++k)
        if (part.value[k] > probe_->level) return part.time[k];
      return std::numeric_limits<double>::quiet_NaN();
    }
    if (probe_->take == "period") return period(part);
    double sum = 0;  // "mean"
    for (std::size_t k = 1; k < part.time.size(); ++k)
      sum += (part.time[k] - part.time[k - 1]) * (part.value[k] + part.value[k - 1]) / 2;
    return sum / (part.time.back() - part.time.front());
  }

 private:
  bool is_field() const {
    return probe_->of == "displacement" || probe_->of == "velocity" || probe_->of == "stress";
  }
  bool counts(const mpm::Particles<D>& particles, std::size_t p) const {
    return probe_->body == 0 || particles.body[p] == probe_->body - 1;
  }

  double value(const mpm::Particles<D>& particles, const mpm::Ledger& ledger) const {
    if (probe_->of == "kinetic") return ledger.kinetic;
    if (probe_->of == "strain") return ledger.strain;
    if (probe_->of == "total") return ledger.total();
    if (probe_->of == "angular") return ledger.angular[2];
    double sum = probe_->of == "front" ? -std::numeric_limits<double>::infinity() : 0;
    const int d = axes_[0];
    for (std::size_t p = 0; p < particles.size(); ++p) {
      if (probe_->of == "front") {
        if (counts(particles, p)) sum = std::max(sum, particles.x[p][d]);
      } else if (weights_[p] != 0) {
        sum += weights_[p] * (probe_->of == "displacement" ? particles.x[p][d] - particles.X[p][d]
                              : probe_->of == "velocity"   ? particles.v[p][d]
                                                           : particles.stress[p](d, axes_[1]));
      }
    }
    return sum;
  }

  // Twice the mean time between zeros of what exceeds the level.
  double period(const Trace& part) const {
    std::vector<double> zeros;
    for (std::size_t k = 1; k < part.time.size(); ++k) {
      const double a = part.value[k - 1] - probe_->level, b = part.value[k] - probe_->level;
      if ((a < 0) != (b < 0))
        zeros.push_back(part.time[k - 1] + (part.time[k] - part.time[k - 1]) * a / (a - b));
    }
    if (zeros.size() < 2) return std::numeric_limits<double>::quiet_NaN();
    return 2 * (zeros.back() - zeros.front()) / static_cast<double>(zeros.size() - 1);
  }

  const Probe* probe_;
  std::array<int, 2> axes_{};
  std::vector<double> weights_;
  Trace trace_;
};

Measured probes(const Request& request) {
  Measured measured;
  std::visit(
      [&]<int D>(const mpm::ProblemFile<D>& file) {
        mpm::Simulation<D> simulation(file.problem);
        std::vector<Gauge<D>> gauges;
        for (const Probe& probe : request.study.probes) gauges.emplace_back(probe, simulation);
        const bool account = std::any_of(gauges.begin(), gauges.end(),
                                         [](const auto& each) { return each.needs_account(); });
        measured.note = run_to_end(simulation, file, [&] {
          const mpm::Ledger now = account ? mpm::account(simulation) : mpm::Ledger{};
          for (Gauge<D>& each : gauges) each.read(simulation, now);
        });
        add_fate(measured, simulation, file);
        const bool finished = measured.note.empty();
        for (std::size_t k = 0; k < gauges.size(); ++k)
          measured.add(request.study.probes[k].name, gauges[k].result(finished));
      },
      request.load());
  return measured;
}

}  // namespace

std::span<const NamedMeasure> probe_measures() {
  static constexpr NamedMeasure all[] = {{"probes", probes}};
  return all;
}

}  // namespace recon::program
