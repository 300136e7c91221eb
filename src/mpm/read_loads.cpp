#include <cmath>
#include <functional>

#include "mpm/bodies.hpp"
#include "mpm/problem_reader.hpp"
#include "recon/core/parallel.hpp"

namespace recon::mpm {
namespace {

using Words = std::vector<std::string>;

template <int D>
std::function<double(double)> magnitude(ProblemReader<D>& reader, const TomlTable& table) {
  reader.note(table, "magnitude");
  const Expression value =
      reader.expression(table, "magnitude", *table.elements("magnitude", 1).front());
  return [value](double t) { return value({0, 0, 0, 0, 0, 0, t}); };
}

template <int D>
void read_pressure(ProblemReader<D>& reader, const TomlTable& table) {
  Problem<D>& problem = reader.problem();
  const int bodies = static_cast<int>(problem.materials.size());
  const int body = table.integer("body", 1, 1, bodies) - 1;
  Words sides;
  for (int d = 0; d < D; ++d)
    for (const char* end : {"_lower", "_upper"})
      sides.push_back(std::string(1, static_cast<char>('x' + d)) + end);
  sides.insert(sides.end(), {"inner", "outer"});
  const std::string side = table.choice("side", sides, true);
  std::function<Vector<D>(const Vector<D>&)> normal;
  std::function<double(const Vector<D>&)> height;
  if (side == "inner" || side == "outer") {
    const Vector<D> centre =
        table.has("centre") ? reader.vector(table, "centre") : Vector<D>::Zero();
    const double sign = side == "inner" ? -1 : 1;
    normal = [=](const Vector<D>& X) -> Vector<D> { return sign * (X - centre).normalized(); };
    height = [=](const Vector<D>& X) { return sign * (X - centre).norm(); };
  } else {
    const Vector<D> out = (side.ends_with("lower") ? -1 : 1) * Vector<D>::Unit(side[0] - 'x');
    normal = [=](const Vector<D>&) { return out; };
    height = [=](const Vector<D>& X) { return X.dot(out); };
  }
  const auto value = magnitude(reader, table);
  for (const auto& part : surface<D>(problem.particles, body, normal, height))
    problem.loads.push_back({part.particle, Vector<D>::Zero(), part.area, value});
  table.finish();
}

}  // namespace

template <int D>
void read_boundaries(ProblemReader<D>& reader) {
  const Words axes{"x", "y", "z"};
  for (const TomlTable& table : reader.file().tables("boundary")) {
    Boundary<D> boundary;
    const std::string axis = table.choice("axis", std::span(axes).subspan(0, D), true);
    boundary.axis = axis[0] - 'x';
    boundary.at = table.number("at");
    const std::string kind = table.choice("kind", Words{"fixed", "roller", "velocity"}, true);
    if (kind == "fixed") boundary.velocity.fill(0.0);
    if (kind == "roller") boundary.velocity[boundary.axis] = 0.0;
    if (kind == "velocity") {
      int d = 0;
      for (const toml::node* node : table.elements("velocity", D)) {
        if (const auto value = node->value<double>(); value && std::isfinite(*value))
          boundary.velocity[d] = *value;
        else if (node->value_or(std::string()) != "free")
          table.fail_at(*node, "velocity", "a number or \"free\" is needed");
        ++d;
      }
    }
    table.finish();
    checked(table, "at", [&] { boundary.validate(reader.problem().grid); });
    reader.problem().boundaries.push_back(boundary);
  }
}

template <int D>
void read_loads(ProblemReader<D>& reader) {
  Problem<D>& problem = reader.problem();
  const TomlTable loads = reader.file().table("loads");
  if (loads.has("gravity")) problem.gravity = reader.vector(loads, "gravity");
  if (loads.has("body_force")) {
    if (problem.exact) loads.fail("body_force", "is given by the manufactured solution");
    const auto force = reader.expressions(loads, "body_force");
    problem.body_force = [force](const Particles<D>& particles, double t, int threads,
                                 std::vector<Vector<D>>& out) {
      parallel_blocks(particles.size(), 1024, threads, [&](std::size_t begin, std::size_t end) {
        for (int d = 0; d < D; ++d) {
          auto value = force[d].evaluator();
          for (std::size_t p = begin; p < end; ++p)
            out[p][d] += value(variables<D>(particles.X[p], particles.x[p], t));
        }
      });
    };
  }
  loads.finish();
  for (const TomlTable& table : reader.file().tables("point_load")) {
    const Vector<D> at = reader.vector(table, "at");
    Load<D> load;
    load.direction = reader.vector(table, "direction");
    load.magnitude = magnitude(reader, table);
    for (std::size_t p = 1; p < problem.particles.size(); ++p)
      if ((problem.particles.X[p] - at).norm() < (problem.particles.X[load.particle] - at).norm())
        load.particle = p;
    table.finish();
    problem.loads.push_back(load);
  }
  for (const TomlTable& table : reader.file().tables("pressure")) read_pressure(reader, table);
}

template void read_boundaries(ProblemReader<1>&);
template void read_boundaries(ProblemReader<2>&);
template void read_boundaries(ProblemReader<3>&);
template void read_loads(ProblemReader<1>&);
template void read_loads(ProblemReader<2>&);
template void read_loads(ProblemReader<3>&);

}  // namespace recon::mpm
