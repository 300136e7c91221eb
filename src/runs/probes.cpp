#include "recon/runs/probes.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <span>

#include "core/brief.hpp"
#include "recon/core/names.hpp"
#include "recon/operators/reconstruct.hpp"
#include "recon/runs/external.hpp"
#include "recon/runs/frames.hpp"
#include "runs/angular.hpp"
#include "runs/bodies.hpp"
#include "runs/particle_values.hpp"

namespace recon::mpm {
namespace {

using recon::detail::brief_place;
using recon::detail::require;
using Words = std::vector<std::string>;
constexpr double none = std::numeric_limits<double>::quiet_NaN();

// The columns of a field.
void add_columns(const std::string& name, int components, Words& columns) {
  if (components == 1) return columns.push_back(name);
  for (int c = 0; c < components; ++c) {
    const int axes = components == 9 ? 3 : components;
    std::string column = name + "_";
    if (components == 9) column += "xyz"[c / axes];
    columns.push_back(column + "xyz"[c % axes]);
  }
}

template <int D>
Words columns_of(const Problem<D>& problem, const Words& fields) {
  const auto known = particle_fields_of(problem, problem.particles);
  Words columns;
  for (const std::string& name : fields) {
    const auto field = known.find(name);
    if (field == known.end())
      throw InvalidArgument("fields", name, suggest(name, particle_fields()));
    add_columns(name, field->second.components, columns);
  }
  require(!columns.empty(), "fields", 0, "must be at least one");
  return columns;
}

// Appends fields of the view's own particles to rows.
template <int D>
class FieldsOf {
 public:
  FieldsOf(const View<D>& view, const Words& fields) : view_(view), fields_(fields) {}

  void add(std::size_t p, std::vector<double>& row) const {
    for (const std::string& name : fields_) {
      const ParticleField& field = known_.at(name);
      row.resize(row.size() + static_cast<std::size_t>(field.components));
      double* const to = row.data() + row.size() - field.components;
      field.put(p, to);
      if (name == "id") *to = static_cast<double>(view_.number_of(p));
    }
  }

 private:
  const View<D>& view_;
  const Words& fields_;
  std::map<std::string, ParticleField> known_ =
      particle_fields_of(view_.problem(), view_.particles());
};

// Sums of all parts of a state, which wait for each other once.
template <int D>
void sum_together(const View<D>& view, std::initializer_list<std::span<double>> several) {
  std::vector<double> all;
  for (const std::span<double> some : several) all.insert(all.end(), some.begin(), some.end());
  view.sum(all);
  auto next = all.begin();
  for (const std::span<double> some : several)
    for (double& each : some) each = *next++;
}

// What the parts of a state have found, in rows that begin with the number of a particle: in the
// order of these.
template <int D>
std::vector<std::vector<double>> rows_of_all(const View<D>& view, std::vector<double> of_this_part,
                                             std::size_t columns) {
  const std::vector<double> all = view.of_all(std::move(of_this_part));
  std::vector<std::vector<double>> rows;
  for (auto at = all.begin(); at != all.end(); at += static_cast<std::ptrdiff_t>(columns))
    rows.emplace_back(at, at + static_cast<std::ptrdiff_t>(columns));
  std::sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a[0] < b[0]; });
  return rows;
}

}  // namespace

template <int D>
Probe<D> particle_probe(const Problem<D>& problem, const Vector<D>& at, const Words& fields) {
  Probe<D> probe{"particle", columns_of(problem, fields), {}};
  const Particles<D>& particles = problem.particles;
  const std::size_t nearest = nearest_particle(particles, at);
  const double away = (particles.X[nearest] - at).norm();
  const double reach = particles.half_edges[nearest].colwise().norm().sum();
  if (!(away <= reach * (1 + 1e-9)))
    recon::detail::throw_invalid("at", brief_place(at),
                                 "lies in no body: the nearest particle is " +
                                     recon::detail::brief(away, 6) + " away, at " +
                                     brief_place(particles.X[nearest]));
  probe.measure = [fields, nearest](const View<D>& view) {
    std::vector<double> found;
    if (const auto here = view.place_of(nearest)) FieldsOf<D>(view, fields).add(*here, found);
    return view.of_all(std::move(found));
  };
  return probe;
}

template <int D>
Probe<D> point_probe(const Problem<D>& problem, const Vector<D>& at, double radius,
                     const Words& fields) {
  Probe<D> probe{"point", columns_of(problem, fields), {}};
  require(at.allFinite() && problem.grid.contains(at), "at", brief_place(at),
          "must lie in the grid");
  require(radius > 0 && std::isfinite(radius), "radius", radius, "must be positive and finite");
  for (const std::string& field : fields)
    require(field != "id" && field != "body", "fields", field, "has no meaning between particles");
  probe.measure = [fields, at, radius, count = probe.columns.size()](const View<D>& view) {
    // Number, place and fields of each particle that is near.
    const FieldsOf<D> fields_of(view, fields);
    std::vector<double> here;
    for (std::size_t p = 0; p < view.state().own(); ++p) {
      const Vector<D>& x = view.particles().x[p];
      if (!((x - at).squaredNorm() < radius * radius)) continue;
      here.push_back(static_cast<double>(view.number_of(p)));
      here.insert(here.end(), x.data(), x.data() + D);
      fields_of.add(p, here);
    }
    std::vector<Vector<D>> places;
    std::vector<double> values;
    for (const std::vector<double>& row : rows_of_all(view, std::move(here), 1 + D + count)) {
      places.push_back(Eigen::Map<const Vector<D>>(row.data() + 1));
      values.insert(values.end(), row.begin() + 1 + D, row.end());
    }
    std::vector<double> found(count, none);
    if (places.empty()) return found;
    const std::vector<Vector<D>> target{at};
    const Reconstruction fit = reconstruct(points_of(places), points_of(target),
                                           {.degree = 1, .neighbours = Radius{radius}});
    const FieldView<double> fields_there{places.size(), static_cast<int>(count), values.data(),
                                         static_cast<std::ptrdiff_t>(count * sizeof(double)),
                                         sizeof(double)};
    const Eigen::MatrixXd mean = fit.apply(fields_there);
    for (std::size_t c = 0; c < count; ++c) found[c] = mean(0, static_cast<Eigen::Index>(c));
    return found;
  };
  return probe;
}

template <int D>
Probe<D> section_probe(const Problem<D>& problem, int axis, double at) {
  require(axis >= 0 && axis < D, "axis", axis, "must be an axis of the grid");
  require(at >= problem.grid.lower()[axis] && at <= problem.grid.upper(axis), "at", at,
          "must lie in the grid");
  Probe<D> probe{"section", {}, {}};
  constexpr int turns = D == 3 ? 3 : D - 1;  // components of the moment
  for (int d = 0; d < D; ++d) probe.columns.push_back(std::string("force_") + "xyz"[d]);
  for (int d = 3 - turns; d < 3; ++d) probe.columns.push_back(std::string("moment_") + "xyz"[d]);
  probe.columns.push_back("area");
  add_columns("stress", 9, probe.columns);
  probe.measure = [axis, at](const View<D>& view) {
    const Particles<D>& particles = view.particles();
    const double h = view.problem().grid.h();
    const auto known = particle_fields_of(view.problem(), particles);
    const ParticleField& full_stress = known.at("stress");
    double area = 0;
    Vector<D> centre = Vector<D>::Zero(), force = Vector<D>::Zero();
    std::array<double, 3> moment{};
    std::array<double, 9> mean{};
    const auto each = [&](const auto& add) {
      for (std::size_t p = 0; p < view.state().own(); ++p) {
        const double w = 1 - std::abs(particles.x[p][axis] - at) / h;
        if (w > 0) add(p, particles.volume(p) * w / h);
      }
    };
    each([&](std::size_t p, double part) {
      area += part;
      centre += part * particles.x[p];
    });
    sum_together(view, {{&area, 1}, {centre.data(), D}});
    if (area > 0) centre /= area;
    each([&](std::size_t p, double part) {
      const Vector<D> pull = part * particles.stress[p].col(axis);
      force += pull;
      add_angular<D>(moment, particles.x[p] - centre, pull);
      std::array<double, 9> stress;
      full_stress.put(p, stress.data());
      for (int c = 0; c < 9; ++c) mean[c] += part * stress[c];
    });
    sum_together(view, {{force.data(), D}, moment, mean});
    std::vector<double> found(force.data(), force.data() + D);
    found.insert(found.end(), moment.end() - turns, moment.end());
    found.push_back(area);
    for (const double sum : mean) found.push_back(area > 0 ? sum / area : none);
    return found;
  };
  return probe;
}

template <int D>
Probe<D> reaction_probe(const Problem<D>& problem, std::size_t boundary) {
  require(boundary < problem.boundaries.size(), "boundary", boundary + 1,
          "must be the number of a boundary");
  require(!problem.boundaries[boundary].images, "boundary", boundary + 1,
          "must hold nodes: one with images of particles holds none");
  Probe<D> probe{"reaction", {}, {}};
  for (int d = 0; d < D; ++d) probe.columns.push_back(std::string("force_") + "xyz"[d]);
  probe.measure = [boundary](const View<D>& view) {
    view.require_mapped("external forces");
    std::vector<double> sum(D);
    for (const Reaction& each : external_forces(view.state(), view.step()).reactions)
      if (each.boundary == boundary) sum[static_cast<std::size_t>(each.axis)] += each.force;
    view.sum(sum);
    return sum;
  };
  return probe;
}

template <int D>
std::string probes_header(const std::vector<Probe<D>>& probes) {
  std::string header = "step,time";
  for (const Probe<D>& probe : probes)
    for (const std::string& column : probe.columns) header += "," + probe.name + "." + column;
  return header;
}

template <int D>
std::string probes_row(const std::vector<Probe<D>>& probes, const View<D>& view) {
  std::string row = std::to_string(view.state().steps);
  const auto put = [&](double value) {
    char text[32];
    row += ',';
    if (std::isfinite(value)) row.append(text, std::to_chars(text, text + sizeof text, value).ptr);
  };
  put(view.state().time);
  for (const Probe<D>& probe : probes)
    for (const double value : probe.measure(view)) put(value);
  return row;
}

#define RECON_INSTANTIATE(D)                                                                \
  template Probe<D> particle_probe(const Problem<D>&, const Vector<D>&, const Words&);      \
  template Probe<D> point_probe(const Problem<D>&, const Vector<D>&, double, const Words&); \
  template Probe<D> section_probe(const Problem<D>&, int, double);                          \
  template Probe<D> reaction_probe(const Problem<D>&, std::size_t);                         \
  template std::string probes_header(const std::vector<Probe<D>>&);                         \
  template std::string probes_row(const std::vector<Probe<D>>&, const View<D>&);
RECON_INSTANTIATE(1)
RECON_INSTANTIATE(2)
RECON_INSTANTIATE(3)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
