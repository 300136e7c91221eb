#include "recon/runs/frames.hpp"

#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <map>

#include "recon/core/names.hpp"
#include "recon/io/write.hpp"
#include "runs/material_keys.hpp"

namespace recon::mpm {
namespace {

std::string file_name(const std::string& name, const char* kind, std::size_t number,
                      const char* extension) {
  char digits[24];
  std::snprintf(digits, sizeof digits, "_%04zu", number);
  return name + "_" + kind + digits + extension;
}

void write_list(const std::filesystem::path& folder, const std::string& name, const char* kind,
                const char* extension, const std::vector<double>& times, std::size_t first) {
  std::vector<TimedFile> files;
  for (std::size_t i = first; i < times.size(); ++i)
    files.push_back({times[i], file_name(name, kind, i, extension)});
  write_pvd(folder / (name + "_" + kind + ".pvd"), files);
}

// ---- fields of the particles --------------------------------------------------------------------
using Tensor = Eigen::Matrix<double, 3, 3>;

// With `beyond` on the diagonal along the axes that the problem does not have.
template <int D>
Tensor full(const Matrix<D>& matrix, double beyond) {
  Tensor out = beyond * Tensor::Identity();
  out.template topLeftCorner<D, D>() = matrix;
  return out;
}

template <int D>
Tensor full_stress(const Problem<D>& problem, const Particles<D>& particles, std::size_t p) {
  double beyond = 0;
  if constexpr (D < 3)
    beyond = std::visit(
        [&](const auto& material) {
          if constexpr (history_of<std::decay_t<decltype(material)>>() > 0) {
            const std::size_t history = particles.history.size() / particles.size();
            return material.template out_of_plane<D>(particles.F[p], particles.stress[p],
                                                     &particles.history[p * history]);
          } else {
            return material.template out_of_plane<D>(particles.F[p], particles.stress[p]);
          }
        },
        problem.materials[static_cast<std::size_t>(particles.body[p])]);
  return full<D>(particles.stress[p], beyond);
}

// The names of the history variables of all materials.
std::vector<std::string> history_fields() {
  std::vector<std::string> names;
  for_each_material([&]<class M>(const M&) {
    if constexpr (history_of<M>() > 0)
      names.insert(names.end(), M::history.begin(), M::history.end());
  });
  return names;
}

// NaN where the particle's material has no such variable.
template <int D>
double remembered(const Problem<D>& problem, const Particles<D>& particles, std::size_t p,
                  std::string_view name) {
  double value = std::numeric_limits<double>::quiet_NaN();
  const auto find = [&]<class M>(const M&) {
    const std::size_t history = particles.history.size() / particles.size();
    for (std::size_t i = 0; i < history_of<M>(); ++i)
      if constexpr (history_of<M>() > 0)
        if (M::history[i] == name) value = particles.history[p * history + i];
  };
  std::visit(find, problem.materials[static_cast<std::size_t>(particles.body[p])]);
  return value;
}

double pressure(const Tensor& stress) {
  return -stress.trace() / 3;
}

double von_mises(const Tensor& stress) {
  return std::sqrt(1.5) * (stress + pressure(stress) * Tensor::Identity()).norm();
}

// put(p, to) writes the `components` numbers of particle p.
struct ParticleField {
  int components;
  std::function<void(std::size_t p, double* to)> put;
  NumberType type = NumberType::float64;
  FieldKind kind = FieldKind::scalars;
};

template <int D>
std::map<std::string, ParticleField> fields_of(const Problem<D>& problem,
                                               const Particles<D>& particles) {
  const auto number = [](const auto& get) {
    return ParticleField{1, [get](std::size_t p, double* to) { *to = get(p); }};
  };
  const auto whole = [](const auto& get) {
    return ParticleField{1, [get](std::size_t p, double* to) { *to = get(p); }, NumberType::int32};
  };
  const auto vector = [](const auto& get) {
    return ParticleField{D,
                         [get](std::size_t p, double* to) {
                           const Vector<D> value = get(p);
                           for (int d = 0; d < D; ++d) to[d] = value[d];
                         },
                         NumberType::float64, FieldKind::vector};
  };
  const auto tensor = [](const auto& get) {
    return ParticleField{9,
                         [get](std::size_t p, double* to) {
                           const Tensor value = get(p);
                           for (int c = 0; c < 9; ++c) to[c] = value(c / 3, c % 3);
                         },
                         NumberType::float64, FieldKind::tensor};
  };
  const auto stress = [&](std::size_t p) { return full_stress(problem, particles, p); };
  std::map<std::string, ParticleField> fields{
      {"velocity", vector([&](std::size_t p) { return particles.v[p]; })},
      {"displacement",
       vector([&](std::size_t p) -> Vector<D> { return particles.x[p] - particles.X[p]; })},
      {"stress", tensor(stress)},
      {"von_mises", number([=](std::size_t p) { return von_mises(stress(p)); })},
      {"pressure", number([=](std::size_t p) { return pressure(stress(p)); })},
      {"F", tensor([&](std::size_t p) { return full<D>(particles.F[p], 1); })},
      {"det_F", number([&](std::size_t p) { return particles.F[p].determinant(); })},
      {"density", number([&](std::size_t p) { return particles.density(p); })},
      {"mass", number([&](std::size_t p) { return particles.mass[p]; })},
      {"volume", number([&](std::size_t p) { return particles.volume(p); })},
      {"body", whole([&](std::size_t p) { return particles.body[p]; })},
      {"id", whole([](std::size_t p) { return static_cast<double>(p); })},
      {"velocity_gradient", tensor([&](std::size_t p) { return full<D>(particles.L[p], 0); })},
      {"energy", number([&](std::size_t p) { return particles.energy[p]; })},
  };
  for (const std::string& name : history_fields())
    fields.emplace(
        name, number([&, name](std::size_t p) { return remembered(problem, particles, p, name); }));
  return fields;
}

FieldSet fields_at(double time, std::int64_t step) {
  FieldSet fields;
  fields.time = time;
  fields.step = step;
  return fields;
}

template <int D>
FieldSet fields_of_particles(const Simulation<D>& simulation,
                             const std::vector<std::string>& names) {
  const Particles<D>& particles = simulation.particles();
  const auto known = fields_of(simulation.problem(), particles);
  FieldSet out = fields_at(simulation.time(), simulation.steps());
  for (const std::string& name : names) {
    const auto field = known.find(name);
    if (field == known.end())
      throw InvalidArgument("field of the particles", name, suggest(name, particle_fields()));
    const auto components = static_cast<std::size_t>(field->second.components);
    std::vector<double> values(particles.size() * components);
    for (std::size_t p = 0; p < particles.size(); ++p)
      field->second.put(p, &values[p * components]);
    out.add(name, field->second.components, std::move(values), field->second.type,
            field->second.kind);
  }
  return out;
}

// ---- fields of nodes and cells ------------------------------------------------------------------
// get(i) is a number, or a vector of the problem's dimension.
template <class Get>
std::vector<double> column(std::size_t count, const Get& get) {
  std::vector<double> values;
  for (std::size_t i = 0; i < count; ++i) {
    if constexpr (std::is_arithmetic_v<decltype(get(i))>) {
      values.push_back(static_cast<double>(get(i)));
    } else {
      const auto value = get(i);
      values.insert(values.end(), value.data(), value.data() + value.size());
    }
  }
  return values;
}

void add_reports(FieldSet& fields, std::size_t count, const FitReports& fit,
                 const std::vector<std::uint32_t>& place) {
  std::vector<double> degree(count, -1), rank(count, 0), neighbours(count, 0);
  for (std::size_t i = 0; i < fit.size(); ++i) {
    const std::size_t at = place.empty() ? i : place[i];
    degree[at] = fit[i].degree;
    rank[at] = fit[i].rank;
    neighbours[at] = static_cast<double>(fit[i].neighbours);
  }
  fields.add("fit_degree", 1, std::move(degree), NumberType::int32);
  fields.add("fit_rank", 1, std::move(rank), NumberType::int32);
  fields.add("fit_neighbours", 1, std::move(neighbours), NumberType::int32);
}

}  // namespace

std::vector<std::string> default_particle_fields() {
  return {"velocity", "displacement", "stress", "von_mises", "pressure", "F",
          "det_F",    "density",      "mass",   "volume",    "body",     "id"};
}

std::span<const std::string> particle_fields() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all = default_particle_fields();
    all.insert(all.end(), {"velocity_gradient", "energy"});
    for (const std::string& name : history_fields()) all.push_back(name);
    return all;
  }();
  return names;
}

template <int D>
void write_frame(const std::filesystem::path& folder, const std::string& name,
                 const Simulation<D>& simulation, std::vector<double>& times,
                 const FrameOptions& options) {
  const Grid<D>& grid = simulation.problem().grid;
  recon::detail::require(simulation.mapped(), "frame", "of nodes of another time",
                         "needs a map() before");
  const Nodes<D>& nodes = simulation.nodes();
  const Cells<D>& cells = simulation.cells();
  const std::size_t number = times.size();

  write_vtp(folder / file_name(name, "particles", number, ".vtp"),
            points_of(simulation.particles().x), fields_of_particles(simulation, options.fields));

  FieldSet of_nodes = fields_at(simulation.time(), simulation.steps());
  of_nodes.add("mass", 1, nodes.mass);
  const auto add_vector = [&](const char* field, const std::vector<Vector<D>>& values) {
    of_nodes.add(field, D, column(grid.size(), [&](std::size_t i) { return values[i]; }),
                 NumberType::float64, FieldKind::vector);
  };
  add_vector("velocity", nodes.velocity);
  add_vector("force", nodes.force);
  if (nodes.fit.size() > 0) add_reports(of_nodes, grid.size(), nodes.fit, nodes.fit_nodes);
  // Of the fits, whose stress is that of the problem's own directions.
  const auto add_fits = [&](FieldSet& fields, std::size_t rows) {
    const auto add = [&](const std::string& field, Eigen::Index at) {
      fields.add(field, 1, column(rows, [&](std::size_t c) {
                   return cells.values(static_cast<Eigen::Index>(c), at);
                 }));
    };
    Eigen::Index at = 0;
    add("density", at++);
    for (int r = 0; r < D; ++r)
      for (int c = r; c < D; ++c) add(std::string("stress_") + "xyz"[r] + "xyz"[c], at++);
  };
  const Quadrature quadrature = simulation.problem().method.quadrature;
  if (quadrature == Quadrature::nodal_cells) add_fits(of_nodes, grid.size());
  write_vti(folder / file_name(name, "nodes", number, ".vti"), grid.nodes(), of_nodes);

  if (!cells.fill.empty()) {
    FieldSet of_cells = fields_at(simulation.time(), simulation.steps());
    if (quadrature == Quadrature::cells) {
      add_fits(of_cells, cells.fill.size());
      add_reports(of_cells, cells.fill.size(), cells.fit, {});
    }
    of_cells.add("fill", 1, cells.fill);
    write_vti(folder / file_name(name, "cells", number, ".vti"), cell_centres(grid.nodes()),
              of_cells);
  }
  times.push_back(simulation.time());
  const auto list = [&](const char* kind, const char* extension) {
    write_list(folder, name, kind, extension, times, options.first_listed);
  };
  list("particles", ".vtp");
  list("nodes", ".vti");
  if (!cells.fill.empty()) list("cells", ".vti");
}

template void write_frame(const std::filesystem::path&, const std::string&, const Simulation<1>&,
                          std::vector<double>&, const FrameOptions&);
template void write_frame(const std::filesystem::path&, const std::string&, const Simulation<2>&,
                          std::vector<double>&, const FrameOptions&);
template void write_frame(const std::filesystem::path&, const std::string&, const Simulation<3>&,
                          std::vector<double>&, const FrameOptions&);

}  // namespace recon::mpm
