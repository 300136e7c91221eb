#include "recon/runs/frames.hpp"

#include <cstdio>

#include "recon/core/names.hpp"
#include "recon/io/write.hpp"
#include "runs/particle_values.hpp"

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
  const auto known = particle_fields_of(simulation.problem(), particles);
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
