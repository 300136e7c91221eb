#include "recon/runs/read_problem.hpp"

#include <algorithm>
#include <fstream>
#include <sstream>

#include "recon/runs/compose.hpp"
#include "runs/material_keys.hpp"
#include "runs/problem_reader.hpp"

namespace recon::mpm {
namespace {

using Words = std::vector<std::string>;

// "auto" is this part of the largest stable step.
constexpr double safe_part_of_step = 0.8;

// All keys but those of the method's choices; the sections ask for the same.
const KnownKeys fixed_keys{
    {"title",
     "threads",
     "device",
     "grid.lower",
     "grid.upper",
     "grid.cells",
     "grid.periodic",
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
     "body.angles",
     "body.velocity",
     "body.radius",
     "body.inner",
     "body.outer",
     "body.centre",
     "method.name",
     "time.end",
     "time.rule",
     "time.courant",
     "time.step",
     "time.until",
     "time.tolerance",
     "damping.local",
     "limits.memory",
     "limits.steps",
     "output.frames",
     "output.ledger",
     "output.fields",
     "output.probe_every",
     "output.probe_interval",
     "loads.gravity",
     "loads.body_force"},
    {"constants.*", "body.lower", "body.upper", "body.wkt", "body.file", "body.volume",
     "body.material.kind", "body.material.young", "body.material.poisson", "body.material.density",
     "damping.mass", "boundary.axis", "boundary.at", "boundary.kind", "boundary.velocity",
     "boundary.from", "boundary.to", "boundary.images"}};

KnownKeys known_keys() {
  KnownKeys keys = fixed_keys;
  for (const std::string& key : load_keys()) keys.others.push_back(key);
  for (const std::string& key : probe_keys()) keys.others.push_back(key);
  // "velocity" alone is that of the bodies.
  const auto is_taken = [&](const std::string& key) {
    return std::any_of(keys.settable.begin(), keys.settable.end(),
                       [&](const std::string& each) { return each.ends_with("." + key); });
  };
  for (const std::string& key : method_keys())
    (is_taken(key) ? keys.others : keys.settable).push_back("method." + key);
  for_each_material([&]<class M>(const M&) {
    if constexpr (requires { M::parameters(); })
      for (const auto& [key, member] : M::parameters()) {
        (void)member;
        keys.settable.push_back("material." + std::string(key));
        keys.others.push_back("body.material." + std::string(key));
      }
  });
  return keys;
}

template <int D>
void read_limits(ProblemReader<D>& reader) {
  const TomlTable keys = reader.file().table("limits");
  Limits& limits = reader.out().limits;
  limits.memory = keys.number("memory", limits.memory);
  limits.steps = keys.number("steps", limits.steps);
  checked(keys, "memory", [&] { limits.validate(); });
  keys.finish();
}

template <int D>
void read_grid(ProblemReader<D>& reader) {
  const TomlTable grid = reader.file().table("grid");
  const Vector<D> lower = reader.vector(grid, "lower"), upper = reader.vector(grid, "upper");
  const double cells = grid.number("cells");
  checked(grid, "cells", [&] {
    recon::detail::require(cells > 0, "cells per unit length", cells, "must be positive");
    auto& periodic = reader.problem().periodic;
    int d = 0;
    if (grid.has("periodic"))
      for (const toml::node* node : grid.elements("periodic", D)) {
        if (!node->is_boolean())
          grid.fail_at(*node, "periodic", "true or false is needed for each axis");
        periodic[d++] = node->value_or(false);
      }
    reader.problem().grid = periodic_grid<D>(lower, upper, 1 / cells, periodic);
  });
  grid.finish();
}

// A name, perhaps with choices in it, and choices beside it, which then stand in the name as well:
// what a method is called says what it is. A choice is said in one place only.
template <int D>
void read_method(ProblemReader<D>& reader) {
  const TomlTable table = reader.file().table("method");
  Method& chosen = reader.problem().method;
  std::string name = table.text("name");
  if (name.find('+') == std::string::npos) {
    Words names;
    for (const Method& each : methods()) names.push_back(each.name);
    name = table.choice("name", names, true);
  }
  checked(table, "name", [&] { chosen = composed(name); });
  const Method in_name = chosen;
  const std::vector<std::string> said = keys_of(name);
  chosen.choices([&]<class T>(const char* key, T& choice) {
    if (!table.has(key)) return;
    if (std::find(said.begin(), said.end(), key) != said.end())
      checked(table, key, [&] {
        recon::detail::throw_invalid(
            std::string(key) + " of the method", choice_text(in_name, key),
            "stands in the name '" + name + "' and beside it: once is enough");
      });
    if constexpr (std::is_enum_v<T>)
      set_choice(chosen, key, table.choice(key, names_of<T>()));
    else if constexpr (std::is_same_v<T, bool>)
      choice = table.boolean(key, false);
    else if constexpr (std::is_integral_v<T>)
      choice = table.integer(key, 0, 0, 1000);
    else
      choice = table.number(key);
  });
  table.finish();
  for (const std::string& key : method_keys())
    if (choice_text(chosen, key) != choice_text(in_name, key))
      chosen.name += "+" + key + "=" + choice_text(chosen, key);
  checked(table, "name", [&] { chosen.validate(D); });
}

template <int D>
void read_manufactured(ProblemReader<D>& reader) {
  if (!reader.file().has("manufactured")) return;
  const TomlTable keys = reader.file().table("manufactured");
  const std::string solution = keys.choice("solution", manufactured_names(), true);
  const double G = keys.number("G");
  checked(keys, "solution", [&] {
    reader.out().exact =
        make_manufactured<D>(solution, G, material_of_exact(reader.problem().materials),
                             reader.problem().densities.front());
  });
  follow(reader.out().exact, reader.problem());
  reader.note(keys, "solution");
  reader.note(keys, "G");
  keys.finish();
}

template <int D>
void read_time(ProblemReader<D>& reader) {
  TimeOptions& time = reader.problem().time;
  const TomlTable keys = reader.file().table("time");
  time.end = keys.number("end");
  const std::string rule = keys.choice("rule", Words{"adaptive", "p_wave", "bar_wave", "fixed"});
  time.rule = rule == "adaptive"   ? StepRule::adaptive
              : rule == "p_wave"   ? StepRule::p_wave
              : rule == "bar_wave" ? StepRule::bar_wave
                                   : StepRule::fixed;
  if (const toml::node* courant = keys.raw().get("courant"); courant && courant->is_string()) {
    if (keys.text("courant") != "auto") keys.fail("courant", "a number or \"auto\" is needed");
    const Method& method = reader.problem().method;
    if (time.rule != StepRule::adaptive && time.rule != StepRule::p_wave)
      keys.fail("courant", "\"auto\" is in units of c_p: it needs the rule adaptive or p_wave");
    if (!(stable_courant(method, D) > 0))
      keys.fail("courant",
                "no step is stable with the method " + method.name + ": a number is needed");
    time.courant = safe_part_of_step * stable_courant(method, D);
  } else if (courant) {
    time.courant = keys.number("courant");
  }
  if (time.rule == StepRule::fixed) time.step = keys.number("step");
  if (keys.choice("until", Words{"end", "rest"}) == "rest")
    time.rest = keys.number("tolerance", 1e-4);
  checked(keys, "end", [&] { time.validate(); });
  keys.finish();
}

template <int D>
void read_damping(ProblemReader<D>& reader) {
  Damping& damping = reader.problem().damping;
  const TomlTable keys = reader.file().table("damping");
  damping.local = keys.number("local", 0);
  damping.mass = keys.number("mass", 0);
  checked(keys, "local", [&] { damping.validate(); });
  keys.finish();
}

template <int D>
void read_output(ProblemReader<D>& reader) {
  OutputOptions& options = reader.out().output;
  const TomlTable output = reader.file().table("output");
  options.frames = output.integer("frames", 50, 0, 1000000);
  options.ledger = output.boolean("ledger", true);
  if (output.has("fields")) options.fields = output.choices("fields", particle_fields());
  options.probe_every = output.integer("probe_every", 1, 1, 1000000000);
  if (output.has("probe_interval")) {
    if (output.has("probe_every"))
      output.fail("probe_interval", "stands beside probe_every: only one of them says when");
    options.probe_interval = output.number("probe_interval");
    if (!(options.probe_interval > 0)) output.fail("probe_interval", "must be positive");
  }
  output.finish();
}

template <int D>
ProblemFile<D> read(const std::filesystem::path& path, const toml::table& root) {
  ProblemReader<D> reader(path, root);
  const TomlTable& file = reader.file();
  Problem<D>& problem = reader.problem();
  if (file.has("title")) reader.out().title = file.text("title");
  problem.threads = file.integer("threads", 0, 0, 1024);
  if (file.choice("device", Words{"cpu", "gpu"}) == "gpu") reader.out().device = RunDevice::gpu;
  reader.read_constants();
  read_limits(reader);
  read_grid(reader);
  read_method(reader);
  read_bodies(reader);
  read_manufactured(reader);
  read_boundaries(reader);
  read_loads(reader);
  read_damping(reader);
  read_probes(reader);
  read_time(reader);
  read_output(reader);
  file.finish();
  checked(file, "", [&] { problem.validate(); });
  return std::move(reader.out());
}

}  // namespace

AnyProblem read_problem_text(const std::string& text, const std::filesystem::path& path,
                             std::span<const std::string> settings) {
  const toml::table root = parse_toml(text, path, settings, known_keys());
  const TomlTable file(path, "", root);
  const TomlTable grid = file.table("grid");
  const toml::array* lower = grid.has("lower") ? grid.raw().get("lower")->as_array() : nullptr;
  if (!lower || lower->empty() || lower->size() > 3)
    grid.fail("lower", "1, 2 or 3 numbers in brackets are needed: one for each axis");
  if (lower->size() == 1) return read<1>(path, root);
  if (lower->size() == 2) return read<2>(path, root);
  return read<3>(path, root);
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
