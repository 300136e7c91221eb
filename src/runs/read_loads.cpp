#include <cmath>
#include <functional>

#include "recon/core/parallel.hpp"
#include "runs/bodies.hpp"
#include "runs/problem_reader.hpp"

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

// On the nearest particle.
template <int D>
void read_point_load(ProblemReader<D>& reader, const TomlTable& table) {
  Problem<D>& problem = reader.problem();
  const Vector<D> at = reader.vector(table, "at");
  Load<D> load;
  load.direction = reader.vector(table, "direction");
  load.magnitude = magnitude(reader, table);
  for (std::size_t p = 1; p < problem.particles.size(); ++p)
    if ((problem.particles.X[p] - at).norm() < (problem.particles.X[load.particle] - at).norm())
      load.particle = p;
  problem.loads.push_back(load);
}

// On the particles of a side.
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
}

// The kinds of loads: a list of tables [[name]] with these keys.
template <int D>
struct LoadKind {
  const char* name;
  std::vector<std::string> keys;
  void (*read)(ProblemReader<D>&, const TomlTable&);
};
template <int D>
std::vector<LoadKind<D>> load_kinds() {
  return {{"point_load", {"at", "direction", "magnitude"}, read_point_load<D>},
          {"pressure", {"body", "side", "centre", "magnitude"}, read_pressure<D>}};
}

// The kinds of boundaries: what each holds.
template <int D>
struct BoundaryKind {
  const char* name;
  void (*hold)(Boundary<D>&, const TomlTable&);
};
template <int D>
void hold_given(Boundary<D>& boundary, const TomlTable& table) {
  int d = 0;
  for (const toml::node* node : table.elements("velocity", D)) {
    if (const auto value = node->value<double>(); value && std::isfinite(*value))
      boundary.velocity[d] = *value;
    else if (node->value_or(std::string()) != "free")
      table.fail_at(*node, "velocity", "a number or \"free\" is needed");
    ++d;
  }
}
template <int D>
std::vector<BoundaryKind<D>> boundary_kinds() {
  return {{"fixed", [](Boundary<D>& of, const TomlTable&) { of.velocity.fill(0.0); }},
          {"roller", [](Boundary<D>& of, const TomlTable&) { of.velocity[of.axis] = 0.0; }},
          {"velocity", hold_given<D>}};
}

}  // namespace

std::vector<std::string> load_keys() {
  std::vector<std::string> keys;
  for (const LoadKind<1>& kind : load_kinds<1>())
    for (const std::string& key : kind.keys) keys.push_back(std::string(kind.name) + "." + key);
  return keys;
}

template <int D>
void read_boundaries(ProblemReader<D>& reader) {
  const Words axes{"x", "y", "z"};
  for (const TomlTable& table : reader.file().tables("boundary")) {
    Boundary<D> boundary;
    const std::string axis = table.choice("axis", std::span(axes).subspan(0, D), true);
    boundary.axis = axis[0] - 'x';
    boundary.at = table.number("at");
    Words names;
    for (const BoundaryKind<D>& each : boundary_kinds<D>()) names.emplace_back(each.name);
    const std::string kind = table.choice("kind", names, true);
    for (const BoundaryKind<D>& each : boundary_kinds<D>())
      if (kind == each.name) each.hold(boundary, table);
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
    if (reader.out().exact) loads.fail("body_force", "is given by the manufactured solution");
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
  for (const LoadKind<D>& kind : load_kinds<D>())
    for (const TomlTable& table : reader.file().tables(kind.name)) {
      kind.read(reader, table);
      table.finish();
    }
}

template void read_boundaries(ProblemReader<1>&);
template void read_boundaries(ProblemReader<2>&);
template void read_boundaries(ProblemReader<3>&);
template void read_loads(ProblemReader<1>&);
template void read_loads(ProblemReader<2>&);
template void read_loads(ProblemReader<3>&);

}  // namespace recon::mpm
