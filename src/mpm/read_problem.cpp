#include "recon/mpm/read_problem.hpp"

#include <algorithm>
#include <boost/geometry.hpp>
#include <boost/geometry/geometries/point_xy.hpp>
#include <boost/geometry/geometries/polygon.hpp>
#include <fstream>
#include <map>
#include <numbers>
#include <sstream>

#include "mpm/bodies.hpp"
#include "mpm/expression.hpp"
#include "mpm/toml_reader.hpp"
#include "recon/core/parallel.hpp"
#include "recon/io/read.hpp"
#include "recon/mpm/forecast.hpp"

namespace recon::mpm {
namespace {

using Words = std::vector<std::string>;

// All keys; the tables below ask for the same.
const KnownKeys known_keys{{"title",
                            "threads",
                            "grid.lower",
                            "grid.upper",
                            "grid.cells",
                            "material.kind",
                            "material.young",
                            "material.poisson",
                            "material.density",
                            "manufactured.solution",
                            "manufactured.G",
                            "body.shape",
                            "body.particles",
                            "body.layout",
                            "body.jitter",
                            "body.angular",
                            "body.velocity",
                            "body.radius",
                            "body.inner",
                            "body.outer",
                            "body.centre",
                            "method.name",
                            "method.degree",
                            "method.momentum_correction",
                            "method.basis",
                            "method.order",
                            "method.mass",
                            "method.stress",
                            "method.spline_border",
                            "method.negative_mass",
                            "time.end",
                            "time.rule",
                            "time.courant",
                            "time.step",
                            "limits.memory",
                            "limits.steps",
                            "output.frames",
                            "output.ledger",
                            "output.fields",
                            "loads.gravity",
                            "loads.body_force"},
                           {"constants.*",
                            "body.lower",
                            "body.upper",
                            "body.wkt",
                            "body.file",
                            "body.volume",
                            "body.material.kind",
                            "body.material.young",
                            "body.material.poisson",
                            "body.material.density",
                            "boundary.axis",
                            "boundary.at",
                            "boundary.kind",
                            "boundary.velocity",
                            "point_load.at",
                            "point_load.direction",
                            "point_load.magnitude",
                            "pressure.body",
                            "pressure.side",
                            "pressure.centre",
                            "pressure.magnitude"}};

// A value or a list of them as a text that does not depend on how numbers are written.
std::string text_of(const toml::node& node) {
  if (const toml::array* array = node.as_array()) {
    std::string text;
    for (const toml::node& each : *array) text += (text.empty() ? "" : ", ") + text_of(each);
    return "[" + text + "]";
  }
  if (node.is_number()) {
    char text[32];
    std::snprintf(text, sizeof text, "%.12g", node.value_or(0.0));
    return text;
  }
  return "'" + node.value_or(std::string()) + "'";
}

template <int D>
class Reader {
 public:
  Reader(const std::filesystem::path& path, const toml::table& root)
      : path_(path), file_(path, "", root) {}

  ProblemFile<D> read() {
    Problem<D>& problem = out_.problem;
    if (file_.has("title")) problem.title = file_.text("title");
    problem.threads = file_.integer("threads", 0, 0, 1024);
    read_constants();
    read_limits();
    read_grid();
    read_method();
    read_bodies();
    read_manufactured();
    read_boundaries();
    read_loads();
    read_time();
    const TomlTable output = file_.table("output");
    out_.output.frames = output.integer("frames", 50, 0, 1000000);
    out_.output.ledger = output.boolean("ledger", true);
    if (output.has("fields")) out_.output.fields = output.choices("fields", particle_fields());
    output.finish();
    file_.finish();
    checked(file_, "", [&] { problem.validate(); });
    return std::move(out_);
  }

 private:
  // Runs `work`; what it finds wrong is the fault of the key that it names, or else of this one.
  template <class Work>
  static void checked(const TomlTable& table, std::string_view key, Work&& work) {
    try {
      work();
    } catch (const InvalidArgument& error) {
      table.fail(table.raw().contains(error.argument()) ? error.argument() : key, error.what());
    } catch (const std::invalid_argument& error) {
      table.fail(key, error.what());
    }
  }

  // Problem::formulas has the text of this key.
  void note(const TomlTable& table, std::string_view key) {
    if (const toml::node* node = table.raw().get(key))
      out_.problem.formulas[table.full(key)] = text_of(*node);
  }

  Vector<D> vector(const TomlTable& table, std::string_view key) const {
    const std::vector<double> values = table.numbers(key, D);
    return Eigen::Map<const Vector<D>>(values.data());
  }

  Expression expression(const TomlTable& table, std::string_view key,
                        const toml::node& node) const {
    if (const auto number = node.value<double>(); number && !node.is_boolean()) {
      if (!std::isfinite(*number)) table.fail_at(node, key, "must be finite");
      return *number;
    }
    const auto text = node.value_exact<std::string>();
    if (!text) table.fail_at(node, key, "a number or an expression in quotes is needed");
    try {
      return {*text, constants_};
    } catch (const std::invalid_argument& error) {
      table.fail_at(node, key, error.what());
    }
  }
  std::array<Expression, D> expressions(const TomlTable& table, std::string_view key) {
    note(table, key);
    std::array<Expression, D> all;
    int d = 0;
    for (const toml::node* node : table.elements(key, D)) all[d++] = expression(table, key, *node);
    return all;
  }

  static Expression::Variables variables(const Vector<D>& X, const Vector<D>& x, double t) {
    Expression::Variables at{};
    for (int d = 0; d < D; ++d) {
      at[d] = X[d];
      at[3 + d] = x[d];
    }
    at[6] = t;
    return at;
  }

  // Numbers, and formulas of other constants, in any order.
  void read_constants() {
    const TomlTable table = file_.table("constants");
    Words open;
    for (const auto& [key, node] : table.raw()) open.emplace_back(key.str());
    for (bool last_try = false; !open.empty();) {
      Words later;
      for (const std::string& key : open) {
        try {
          const toml::node& node = *table.elements(key, 1).front();
          const auto text = node.value_exact<std::string>();
          std::map<std::string, double> with_it = constants_;
          with_it[key] = text ? Formula(*text, {}, constants_)({}) : table.number(key);
          Formula("0", Expression::variable_names(), with_it);  // is the name one for formulas?
          constants_ = std::move(with_it);
          note(table, key);
        } catch (const std::invalid_argument& error) {
          if (last_try) table.fail(key, error.what());
          later.push_back(key);
        }
      }
      last_try = later.size() == open.size();
      open = std::move(later);
    }
  }

  void read_limits() {
    const TomlTable keys = file_.table("limits");
    Limits& limits = out_.problem.limits;
    limits.memory = keys.number("memory", limits.memory);
    limits.steps = keys.number("steps", limits.steps);
    checked(keys, "memory", [&] { limits.validate(); });
    keys.finish();
  }

  void read_grid() {
    const TomlTable grid = file_.table("grid");
    const Vector<D> lower = vector(grid, "lower"), upper = vector(grid, "upper");
    const double cells = grid.number("cells");
    checked(grid, "cells", [&] {
      recon::detail::require(cells > 0, "cells per unit length", cells, "must be positive");
      out_.problem.grid = Grid<D>(lower, upper, 1 / cells);
    });
    grid.finish();
  }

  void read_method() {
    const TomlTable method = file_.table("method");
    Method& chosen = out_.problem.method;
    Words names;
    for (const Method& each : methods()) names.push_back(each.name);
    chosen = method_named(method.choice("name", names, true));
    chosen.degree = method.integer("degree", chosen.degree, 1, 3);
    chosen.order = method.integer("order", chosen.order, 1, 1000);
    chosen.momentum_correction = method.boolean("momentum_correction", false);
    choose(method, "basis", chosen.basis,
           {Basis::linear, Basis::q8, Basis::q9, Basis::bspline2, Basis::bspline3,
            Basis::mls_bspline2});
    choose(method, "mass", chosen.mass, {MassMatrix::lumped, MassMatrix::consistent});
    choose(method, "stress", chosen.stress, {StressUpdate::last, StressUpdate::first});
    choose(method, "spline_border", chosen.border,
           {SplineBorder::corrected, SplineBorder::extra_column, SplineBorder::linear_cells});
    chosen.stop_at_negative_mass =
        method.choice("negative_mass", Words{"report", "stop"}) == "stop";
    method.finish();
    checked(method, "name", [&] { chosen.validate(D); });
  }

  // One of `values` by its name; without the key it stays as it is.
  template <class Enum>
  static void choose(const TomlTable& table, std::string_view key, Enum& value,
                     std::initializer_list<Enum> values) {
    if (!table.has(key)) return;
    Words names;
    for (const Enum each : values) names.emplace_back(name_of(each));
    const std::string chosen = table.choice(key, names);
    for (const Enum each : values)
      if (name_of(each) == chosen) value = each;
  }

  // The material of `table`, or that of the whole file.
  Material material(const TomlTable& table, double& density) const {
    const TomlTable keys =
        table.has("material") ? table.table("material") : file_.table("material");
    Lame elastic;
    const double young = keys.number("young"), poisson = keys.number("poisson");
    checked(keys, "young", [&] { elastic = Lame::from(young, poisson); });
    density = keys.number("density");
    checked(keys, "density", [&] { validate_density(density); });
    const std::string kind = keys.choice("kind", Words{"neo_hookean", "linear_elastic"});
    keys.finish();
    if (kind == "neo_hookean") return NeoHookean{elastic};
    return LinearElastic{elastic};
  }

  void read_bodies() {
    Problem<D>& problem = out_.problem;
    const auto bodies = file_.tables("body");
    if (bodies.empty()) file_.fail("body", "a [[body]] is needed");
    for (const TomlTable& body : bodies) {
      const int number = static_cast<int>(problem.materials.size());
      double density = 0;
      problem.materials.push_back(material(body, density));
      problem.densities.push_back(density);
      const std::size_t before = problem.particles.size();
      fill(body, density, number);
      if (problem.particles.size() == before)
        body.fail("shape", "no particle lies in the body and the grid");
      if (body.has("velocity")) set_velocity(body, before);
      body.finish();
    }
  }

  void fill(const TomlTable& body, double density, int number) {
    Problem<D>& problem = out_.problem;
    const Grid<D>& grid = problem.grid;
    const std::string shape =
        body.choice("shape", Words{"box", "disk", "ring", "polygon", "file"}, true);
    if (shape == "file") return fill_from_file(body, density, number);
    const int n = body.integer("particles", 2, 1, 100);
    const std::string layout = body.choice("layout", Words{"cell", "jittered", "polar"});
    const double jitter = layout == "jittered" ? body.number("jitter", 0.5) : 0;
    if (jitter < 0 || jitter > 1) body.fail("jitter", "must lie between 0 and 1");
    Region<D> region;
    if (shape == "box") {
      const Vector<D> lower = vector(body, "lower"), upper = vector(body, "upper");
      if (!(lower.array() < upper.array()).all()) body.fail("upper", "must be above lower");
      region = {lower, upper, [=](const Vector<D>& X) {
                  return (X.array() > lower.array()).all() && (X.array() < upper.array()).all();
                }};
    } else if (shape == "polygon") {
      region = polygon(body);
    } else {
      const Vector<D> centre = vector(body, "centre");
      const double outer = body.number(shape == "disk" ? "radius" : "outer");
      const double inner = shape == "disk" ? 0 : body.number("inner");
      if (!(outer > inner && inner >= 0))
        body.fail(shape == "disk" ? "radius" : "outer", "must be above the inner radius");
      region = {centre.array() - outer, centre.array() + outer, [=](const Vector<D>& X) {
                  const double R = (X - centre).norm();
                  return R >= inner && R <= outer;
                }};
      if (layout == "polar") {
        checked(body, "shape", [&] { require_in_grid(grid, region.lower, region.upper); });
        return fill_polar(body, centre, inner, outer, density, number);
      }
    }
    if (layout == "polar") body.fail("layout", "'polar' is for rings and disks");
    checked(body, "shape", [&] {
      fill_cells(grid, region, n, jitter, density, number, most_particles(), problem.particles);
    });
  }

  // That there is memory for, and numbers.
  double most_particles() const {
    const Problem<D>& problem = out_.problem;
    const double memory = problem.limits.memory > 0 ? problem.limits.memory : available_memory();
    return std::min(memory / bytes_of_particle<D>(problem.method), 4294967294.0) -
           static_cast<double>(problem.particles.size());
  }

  void fill_polar(const TomlTable& body, const Vector<D>& centre, double inner, double outer,
                  double density, int number) {
    if constexpr (D == 2) {
      const double h = out_.problem.grid.h(), n = body.integer("particles", 2, 1, 100);
      const double around = body.number("angular", n * std::numbers::pi * (inner + outer));
      if (!(around > 0)) body.fail("angular", "must be positive");
      fill_ring(centre, inner, outer,
                std::max(1, static_cast<int>(std::lround(n * (outer - inner) / h))),
                std::max(3, static_cast<int>(std::lround(around / h))), density, number,
                out_.problem.particles);
    } else {
      (void)centre, (void)inner, (void)outer, (void)density, (void)number;
      body.fail("layout", "'polar' is for 2-D");
    }
  }

  static Region<D> polygon(const TomlTable& body) {
    namespace bg = boost::geometry;
    using Point = bg::model::d2::point_xy<double>;
    if constexpr (D == 2) {
      bg::model::polygon<Point> shape;
      try {
        bg::read_wkt(body.text("wkt"), shape);
      } catch (const bg::exception& error) {
        body.fail("wkt", std::string("no polygon in WKT: ") + error.what());
      }
      bg::correct(shape);
      std::string reason;
      if (!bg::is_valid(shape, reason)) body.fail("wkt", reason);
      bg::model::box<Point> box;
      bg::envelope(shape, box);
      return {{box.min_corner().x(), box.min_corner().y()},
              {box.max_corner().x(), box.max_corner().y()},
              [shape](const Vector<2>& X) { return bg::within(Point(X[0], X[1]), shape); }};
    } else {
      body.fail("shape", "polygons are for 2-D");
    }
  }

  void fill_from_file(const TomlTable& body, double density, int number) {
    const std::filesystem::path name = body.text("file");
    const ParticleTable table =
        read_particles(name.is_absolute() ? name : path_.parent_path() / name);
    const auto positions = table.positions(D);
    std::vector<double> volumes(table.size());
    if (body.has("volume"))
      std::fill(volumes.begin(), volumes.end(), body.number("volume"));
    else
      volumes = table.column("volume");
    for (std::size_t p = 0; p < table.size(); ++p) {
      if (!(volumes[p] > 0))
        body.fail("file", "volume of " + table.describe_row(p) + " must be positive");
      Vector<D> X;
      for (int d = 0; d < D; ++d) X[d] = positions(p, d);
      if (!out_.problem.grid.contains(X))
        body.fail("file", "position of " + table.describe_row(p) + " must lie in the grid");
      out_.problem.particles.add(X, Matrix<D>::Identity() * (std::pow(volumes[p], 1.0 / D) / 2),
                                 density, number);
    }
  }

  // And its gradient, by central differences.
  void set_velocity(const TomlTable& body, std::size_t first) {
    Particles<D>& particles = out_.problem.particles;
    const auto velocity = expressions(body, "velocity");
    const double step = 1e-4 * out_.problem.grid.h();
    const auto at = [&](const Vector<D>& X) {
      Vector<D> v;
      for (int d = 0; d < D; ++d) v[d] = velocity[d](variables(X, X, 0));
      return v;
    };
    const bool constant = std::all_of(velocity.begin(), velocity.end(),
                                      [](const Expression& e) { return e.is_constant(); });
    checked(body, "velocity", [&] {
      for (std::size_t p = first; p < particles.size(); ++p) {
        particles.v[p] = at(particles.X[p]);
        for (int d = 0; d < D && !constant; ++d) {
          const Vector<D> aside = step * Vector<D>::Unit(d);
          particles.L[p].col(d) =
              (at(particles.X[p] + aside) - at(particles.X[p] - aside)) / (2 * step);
        }
      }
    });
  }

  void read_manufactured() {
    if (!file_.has("manufactured")) return;
    Problem<D>& problem = out_.problem;
    const TomlTable keys = file_.table("manufactured");
    const std::string solution = keys.choice("solution", manufactured_names(), true);
    const double G = keys.number("G");
    checked(keys, "solution", [&] {
      problem.exact = make_manufactured<D>(solution, G, material_of_exact(problem.materials),
                                           problem.densities.front());
    });
    problem.follow_exact();
    note(keys, "solution");
    note(keys, "G");
    keys.finish();
  }

  void read_boundaries() {
    const Words axes{"x", "y", "z"};
    for (const TomlTable& table : file_.tables("boundary")) {
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
      checked(table, "at", [&] { boundary.validate(out_.problem.grid); });
      out_.problem.boundaries.push_back(boundary);
    }
  }

  void read_loads() {
    Problem<D>& problem = out_.problem;
    const TomlTable loads = file_.table("loads");
    if (loads.has("gravity")) problem.gravity = vector(loads, "gravity");
    if (loads.has("body_force")) {
      if (problem.exact) loads.fail("body_force", "is given by the manufactured solution");
      const auto force = expressions(loads, "body_force");
      problem.body_force = [force](const Particles<D>& particles, double t, int threads,
                                   std::vector<Vector<D>>& out) {
        parallel_blocks(particles.size(), 1024, threads, [&](std::size_t begin, std::size_t end) {
          for (int d = 0; d < D; ++d) {
            auto value = force[d].evaluator();
            for (std::size_t p = begin; p < end; ++p)
              out[p][d] += value(variables(particles.X[p], particles.x[p], t));
          }
        });
      };
    }
    loads.finish();
    for (const TomlTable& table : file_.tables("point_load")) {
      const Vector<D> at = vector(table, "at");
      Load<D> load;
      load.direction = vector(table, "direction");
      load.magnitude = magnitude(table);
      for (std::size_t p = 1; p < problem.particles.size(); ++p)
        if ((problem.particles.X[p] - at).norm() < (problem.particles.X[load.particle] - at).norm())
          load.particle = p;
      table.finish();
      problem.loads.push_back(load);
    }
    for (const TomlTable& table : file_.tables("pressure")) read_pressure(table);
  }

  std::function<double(double)> magnitude(const TomlTable& table) {
    note(table, "magnitude");
    const Expression value =
        expression(table, "magnitude", *table.elements("magnitude", 1).front());
    return [value](double t) { return value({0, 0, 0, 0, 0, 0, t}); };
  }

  void read_pressure(const TomlTable& table) {
    Problem<D>& problem = out_.problem;
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
      const Vector<D> centre = table.has("centre") ? vector(table, "centre") : Vector<D>::Zero();
      const double sign = side == "inner" ? -1 : 1;
      normal = [=](const Vector<D>& X) -> Vector<D> { return sign * (X - centre).normalized(); };
      height = [=](const Vector<D>& X) { return sign * (X - centre).norm(); };
    } else {
      const Vector<D> out = (side.ends_with("lower") ? -1 : 1) * Vector<D>::Unit(side[0] - 'x');
      normal = [=](const Vector<D>&) { return out; };
      height = [=](const Vector<D>& X) { return X.dot(out); };
    }
    const auto value = magnitude(table);
    for (const auto& part : surface<D>(problem.particles, body, normal, height))
      problem.loads.push_back({part.particle, Vector<D>::Zero(), part.area, value});
    table.finish();
  }

  void read_time() {
    TimeOptions& time = out_.problem.time;
    const TomlTable keys = file_.table("time");
    time.end = keys.number("end");
    const std::string rule = keys.choice("rule", Words{"adaptive", "p_wave", "bar_wave", "fixed"});
    time.rule = rule == "adaptive"   ? StepRule::adaptive
                : rule == "p_wave"   ? StepRule::p_wave
                : rule == "bar_wave" ? StepRule::bar_wave
                                     : StepRule::fixed;
    if (keys.has("courant")) time.courant = keys.number("courant");
    if (time.rule == StepRule::fixed) time.step = keys.number("step");
    checked(keys, "end", [&] { time.validate(); });
    keys.finish();
  }

  std::filesystem::path path_;
  TomlTable file_;
  std::map<std::string, double> constants_;
  ProblemFile<D> out_;
};

}  // namespace

AnyProblem read_problem_text(const std::string& text, const std::filesystem::path& path,
                             std::span<const std::string> settings) {
  const toml::table root = parse_toml(text, path, settings, known_keys);
  const TomlTable file(path, "", root);
  const TomlTable grid = file.table("grid");
  const toml::array* lower = grid.has("lower") ? grid.raw().get("lower")->as_array() : nullptr;
  if (!lower || lower->empty() || lower->size() > 3)
    grid.fail("lower", "1, 2 or 3 numbers in brackets are needed: one for each axis");
  if (lower->size() == 1) return Reader<1>(path, root).read();
  if (lower->size() == 2) return Reader<2>(path, root).read();
  return Reader<3>(path, root).read();
}

AnyProblem read_problem(const std::filesystem::path& path, std::span<const std::string> settings) {
  std::ifstream file(path, std::ios::binary);
  std::error_code none;
  if (!std::filesystem::exists(path, none)) throw FileError(path, 0, "no such file");
  if (std::filesystem::is_directory(path, none))
    throw FileError(path, 0, "is a folder; a problem file is needed");
  if (!file) throw FileError(path, 0, "cannot be read");
  std::ostringstream text;
  text << file.rdbuf();
  return read_problem_text(text.str(), path, settings);
}

}  // namespace recon::mpm
