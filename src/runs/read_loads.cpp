#include <cmath>
#include <functional>

#include "recon/core/parallel.hpp"
#include "runs/bodies.hpp"
#include "runs/problem_reader.hpp"

namespace recon::mpm {
namespace {

using Words = std::vector<std::string>;

// On the nearest particle.
template <int D>
void read_point_load(ProblemReader<D>& reader, const TomlTable& table) {
  Problem<D>& problem = reader.problem();
  const std::size_t nearest = nearest_particle<D>(problem.particles, reader.vector(table, "at"));
  reader.note(table, "direction");
  reader.note(table, "magnitude");
  const Expression magnitude =
      reader.expression(table, "magnitude", *table.elements("magnitude", 1).front());
  problem.loads.push_back(
      point_load<D>(nearest, reader.vector(table, "direction"), [magnitude](double t) {
        return magnitude({0, 0, 0, 0, 0, 0, t});
      }));
}

// The side of a body that a table names, with this force on each part of it.
template <int D>
void load_side(ProblemReader<D>& reader, const TomlTable& table,
               const std::function<Vector<D>(const LoadedPlace<D>&, double)>& force) {
  Problem<D>& problem = reader.problem();
  const int bodies = static_cast<int>(problem.materials.size());
  const int body = table.integer("body", 1, 1, bodies) - 1;
  Words sides;
  for (int d = 0; d < D; ++d)
    for (const char* end : {"_lower", "_upper"})
      sides.push_back(std::string(1, static_cast<char>('x' + d)) + end);
  sides.insert(sides.end(), {"inner", "outer"});
  const std::string name = table.choice("side", sides, true);
  Side<D> side;
  if (name == "inner" || name == "outer") {
    const Vector<D> centre =
        table.has("centre") ? reader.vector(table, "centre") : Vector<D>::Zero();
    const double sign = name == "inner" ? -1 : 1;
    side = {[=](const Vector<D>& X) -> Vector<D> { return sign * (X - centre).normalized(); },
            [=](const Vector<D>& X) { return sign * (X - centre).norm(); }, true};
  } else {
    const Vector<D> out = (name.ends_with("lower") ? -1 : 1) * Vector<D>::Unit(name[0] - 'x');
    side = {[=](const Vector<D>&) { return out; }, [=](const Vector<D>& X) { return X.dot(out); }};
  }
  for (const auto& part : surface<D>(problem.particles, body, side))
    problem.loads.push_back({part.particle, part.offset, part.area, force});
}

// -p n A.
template <int D>
void read_pressure(ProblemReader<D>& reader, const TomlTable& table) {
  reader.note(table, "magnitude");
  const Expression value =
      reader.expression(table, "magnitude", *table.elements("magnitude", 1).front());
  load_side<D>(reader, table, [value](const LoadedPlace<D>& at, double t) {
    return Vector<D>(-value(variables<D>(at.X, at.x, t)) * at.area);
  });
}

// tau A0, or tau A.
template <int D>
void read_traction(ProblemReader<D>& reader, const TomlTable& table) {
  const auto values = reader.expressions(table, "traction");
  reader.note(table, "area");
  const bool current = table.choice("area", Words{"reference", "current"}) == "current";
  load_side<D>(reader, table, [values, current](const LoadedPlace<D>& at, double t) {
    const auto where = variables<D>(at.X, at.x, t);
    Vector<D> force;
    for (int d = 0; d < D; ++d) force[d] = values[d](where);
    return Vector<D>((current ? at.area : at.area0).norm() * force);
  });
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
          {"pressure", {"body", "side", "centre", "magnitude"}, read_pressure<D>},
          {"traction", {"body", "side", "centre", "traction", "area"}, read_traction<D>}};
}

// The kinds of boundaries: what each holds.
template <int D>
struct BoundaryKind {
  const char* name;
  void (*hold)(ProblemReader<D>&, Boundary<D>&, const TomlTable&);
};
template <int D>
void hold_given(ProblemReader<D>& reader, Boundary<D>& boundary, const TomlTable& table) {
  const std::string needed = "a number, a formula or \"free\" is needed";
  reader.note(table, "velocity");
  int d = -1;
  for (const toml::node* node : table.elements("velocity", D)) {
    ++d;
    if (node->value_or(std::string()) == "free") continue;
    if (!node->is_string() && !(node->is_number() && std::isfinite(node->value_or(0.0))))
      table.fail_at(*node, "velocity", needed);
    const Expression value = reader.expression(table, "velocity", *node, needed);
    if (value.is_constant())
      boundary.velocity[d] = value({});
    else
      boundary.velocity[d] = HeldVelocity<D>(
          [value](const Vector<D>& x, double t) { return value(variables<D>(x, x, t)); });
  }
}
template <int D>
std::vector<BoundaryKind<D>> boundary_kinds() {
  using Reader = ProblemReader<D>;
  const auto roller = [](Reader&, Boundary<D>& of, const TomlTable&) {
    of.velocity[of.axis] = 0.0;
  };
  const auto fixed = [](Reader&, Boundary<D>& of, const TomlTable&) { of.velocity.fill(0.0); };
  const auto symmetry = [](Reader&, Boundary<D>& of, const TomlTable&) {
    of.velocity[of.axis] = 0.0;
    of.symmetry = true;
  };
  return {
      {"fixed", fixed}, {"roller", roller}, {"velocity", hold_given<D>}, {"symmetry", symmetry}};
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
      if (kind == each.name) each.hold(reader, boundary, table);
    if (table.has("from")) boundary.from = reader.vector(table, "from");
    if (table.has("to")) boundary.to = reader.vector(table, "to");
    // Between the nodes no node can be held.
    const Grid<D>& grid = reader.problem().grid;
    const bool between = boundary.at > grid.lower()[boundary.axis] &&
                         boundary.at < grid.upper(boundary.axis) && !boundary.is_on_nodes(grid);
    boundary.images = table.boolean("images", between && kind != "velocity");
    if (boundary.images) boundary.symmetry = false;
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
