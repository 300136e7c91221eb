#include "recon/mpm/frames.hpp"

#include <cstdio>

#include "recon/io/atomic_file.hpp"
#include "recon/io/write.hpp"

namespace recon::mpm {
namespace {

std::string file_name(const std::string& name, const char* kind, std::size_t number,
                      const char* extension) {
  char digits[24];
  std::snprintf(digits, sizeof digits, "_%04zu", number);
  return name + "_" + kind + digits + extension;
}

void write_list(const std::filesystem::path& folder, const std::string& name, const char* kind,
                const char* extension, const std::vector<double>& times) {
  AtomicFile file(folder / (name + "_" + kind + ".pvd"));
  file.write("<VTKFile type=\"Collection\" version=\"1.0\">\n  <Collection>\n");
  for (std::size_t i = 0; i < times.size(); ++i)
    file.write("    <DataSet timestep=\"" + recon::detail::to_text(times[i]) +
               "\" part=\"0\" file=\"" + file_name(name, kind, i, extension) + "\"/>\n");
  file.write("  </Collection>\n</VTKFile>\n");
  file.commit();
}

// get(i) is a number, or a vector of `components`.
template <class Get>
std::vector<double> column(std::size_t count, int components, const Get& get) {
  std::vector<double> values;
  values.reserve(count * static_cast<std::size_t>(components));
  for (std::size_t i = 0; i < count; ++i) {
    if constexpr (std::is_arithmetic_v<decltype(get(i))>) {
      values.push_back(static_cast<double>(get(i)));
    } else {
      const auto value = get(i);
      for (int c = 0; c < components; ++c) values.push_back(value[c]);
    }
  }
  return values;
}

template <int D>
auto upper_triangle(const Matrix<D>& matrix) {
  Eigen::Matrix<double, D*(D + 1) / 2, 1> entries;
  for (int r = 0, k = 0; r < D; ++r)
    for (int c = r; c < D; ++c) entries[k++] = matrix(r, c);
  return entries;
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

FieldSet fields_at(double time, std::int64_t step) {
  FieldSet fields;
  fields.time = time;
  fields.step = step;
  return fields;
}

}  // namespace

template <int D>
void write_frame(const std::filesystem::path& folder, const std::string& name,
                 const Simulation<D>& simulation, std::vector<double>& times) {
  constexpr int stresses = D * (D + 1) / 2;
  const Particles<D>& particles = simulation.particles();
  const Grid<D>& grid = simulation.problem().grid;
  require(simulation.mapped(), "frame", "of nodes of another time", "needs a map() before");
  const Nodes<D>& nodes = simulation.nodes();
  const Cells<D>& cells = simulation.cells();
  const std::size_t number = times.size(), count = particles.size();

  FieldSet of_particles = fields_at(simulation.time(), simulation.steps());
  const auto add = [&](const char* field, int components, const auto& get) {
    of_particles.add(field, components, column(count, components, get));
  };
  add("velocity", D, [&](std::size_t p) { return particles.v[p]; });
  add("displacement", D, [&](std::size_t p) { return Vector<D>(particles.x[p] - particles.X[p]); });
  add("stress", stresses, [&](std::size_t p) { return upper_triangle<D>(particles.stress[p]); });
  add("density", 1, [&](std::size_t p) { return particles.density(p); });
  add("det_F", 1, [&](std::size_t p) { return particles.F[p].determinant(); });
  of_particles.add("body", 1, column(count, 1, [&](std::size_t p) { return particles.body[p]; }),
                   NumberType::int32);
  write_vtp(folder / file_name(name, "particles", number, ".vtp"), points_of(particles.x),
            of_particles);

  FieldSet of_nodes = fields_at(simulation.time(), simulation.steps());
  of_nodes.add("mass", 1, nodes.mass);
  of_nodes.add("velocity", D,
               column(grid.size(), D, [&](std::size_t i) { return nodes.velocity[i]; }));
  of_nodes.add("force", D, column(grid.size(), D, [&](std::size_t i) { return nodes.force[i]; }));
  if (nodes.fit.size() > 0) add_reports(of_nodes, grid.size(), nodes.fit, nodes.fit_nodes);
  const auto add_fits = [&](FieldSet& fields, std::size_t rows) {
    const auto row = [&](std::size_t c) { return cells.values.row(static_cast<Eigen::Index>(c)); };
    fields.add("density", 1, column(rows, 1, [&](std::size_t c) { return double(row(c)[0]); }));
    fields.add("stress", stresses, column(rows, stresses, [&](std::size_t c) {
                 return Eigen::Matrix<double, stresses, 1>(row(c).segment(1, stresses).transpose());
               }));
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
  write_list(folder, name, "particles", ".vtp", times);
  write_list(folder, name, "nodes", ".vti", times);
  if (!cells.fill.empty()) write_list(folder, name, "cells", ".vti", times);
}

template void write_frame(const std::filesystem::path&, const std::string&, const Simulation<1>&,
                          std::vector<double>&);
template void write_frame(const std::filesystem::path&, const std::string&, const Simulation<2>&,
                          std::vector<double>&);
template void write_frame(const std::filesystem::path&, const std::string&, const Simulation<3>&,
                          std::vector<double>&);

}  // namespace recon::mpm
