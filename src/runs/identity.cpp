#include "runs/identity.hpp"

#include <algorithm>

#include "core/brief.hpp"
#include "recon/runs/compose.hpp"
#include "runs/material_keys.hpp"

namespace recon::mpm {
namespace {

std::string text_of(double value) {
  return recon::detail::brief(value == 0 ? 0.0 : value, 12);
}

template <int D>
std::string text_of(const Vector<D>& value) {
  std::string text = text_of(value[0]);
  for (int d = 1; d < D; ++d) text += ", " + text_of(value[d]);
  return text;
}

// A method is what is chosen, whatever it is called.
void add_method(const Method& method, Identity& out) {
  for (const std::string& key : method_keys())
    out.emplace_back("method." + key, choice_text(method, key));
}

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

}  // namespace

template <int D>
Identity identity_of(const Problem<D>& problem, const Particles<D>& particles,
                     const Formulas& formulas) {
  Identity out;
  const auto add = [&](const std::string& key, const std::string& value) {
    out.emplace_back(one_line(key), one_line(value));
  };
  add("the number of dimensions", std::to_string(D));
  add_method(problem.method, out);
  const Grid<D>& grid = problem.grid;
  Vector<D> upper;
  for (int d = 0; d < D; ++d) upper[d] = grid.upper(d);
  add("grid.lower", text_of<D>(grid.lower()));
  add("grid.upper", text_of<D>(upper));
  add("grid.cells", text_of(1 / grid.h()));
  std::string periodic;
  for (int d = 0; d < D; ++d)
    periodic += std::string(d ? ", " : "") + (problem.periodic[d] ? "true" : "false");
  add("grid.periodic", periodic);

  add("the number of bodies", std::to_string(problem.materials.size()));
  std::vector<std::size_t> counts(problem.materials.size());
  for (const std::int32_t body : particles.body) ++counts[static_cast<std::size_t>(body)];
  for (std::size_t b = 0; b < problem.materials.size(); ++b) {
    const std::string body = "body " + std::to_string(b + 1) + ".";
    const Material& material = problem.materials[b];
    add(body + "kind", std::string(name_of(material)));
    const auto [lambda, mu] = lame(material);
    add(body + "young", text_of(mu * (3 * lambda + 2 * mu) / (lambda + mu)));
    add(body + "poisson", text_of(lambda / (2 * (lambda + mu))));
    for (const auto& [key, value] : constants_of(material))
      add(body + std::string(key), text_of(value));
    add(body + "density", text_of(problem.densities[b]));
    add(body + "number of particles", std::to_string(counts[b]));
  }

  add("the number of boundaries", std::to_string(problem.boundaries.size()));
  for (std::size_t b = 0; b < problem.boundaries.size(); ++b) {
    const Boundary<D>& boundary = problem.boundaries[b];
    std::string velocity;
    for (int d = 0; d < D; ++d)
      velocity += (d ? ", " : "") + (!boundary.velocity[d] ? "free"
                                     : boundary.velocity[d]->varies()
                                         ? "a function"
                                         : text_of((*boundary.velocity[d])({}, 0)));
    const std::string key = "boundary " + std::to_string(b + 1) + ".";
    add(key + "axis", std::string(1, "xyz"[boundary.axis]));
    add(key + "at", text_of(boundary.at));
    // Where it is a formula, its text says more.
    if (velocity.find("a function") == std::string::npos || !formulas.contains(key + "velocity"))
      add(key + "velocity", velocity);
    add(key + "from", text_of<D>(boundary.from));
    add(key + "to", text_of<D>(boundary.to));
    add(key + "symmetry", boundary.symmetry ? "true" : "false");
    add(key + "images", boundary.images ? "true" : "false");
  }
  add("loads.gravity", text_of<D>(problem.gravity));
  if (!formulas.contains("loads.body_force"))
    add("loads.body_force", problem.body_force ? "a function" : "none");
  add("the number of loaded particles", std::to_string(problem.loads.size()));
  for (std::size_t i = 0; i < problem.loads.size(); ++i) {
    const Load<D>& load = problem.loads[i];
    add("load " + std::to_string(i + 1), "particle " + std::to_string(load.particle) +
                                             ", offset (" + text_of<D>(load.offset) + "), area (" +
                                             text_of<D>(load.area) + ")");
  }
  add("damping.local", text_of(problem.damping.local));
  add("damping.mass", text_of(problem.damping.mass));
  for (const auto& [key, text] : formulas) add(key, text);
  return out;
}

std::string to_text(const Identity& identity) {
  std::string text;
  for (const auto& [key, value] : identity) text += key + " = " + value + "\n";
  return text;
}

Identity identity_from(const std::string& text) {
  Identity out;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string line = text.substr(at, end - at);
    const std::size_t equals = std::min(line.find(" = "), line.size());
    out.emplace_back(line.substr(0, equals), line.substr(std::min(equals + 3, line.size())));
    at = end + 1;
  }
  return out;
}

std::string difference(const Identity& stored, const Identity& now) {
  std::size_t same = 0;
  while (same < stored.size() && same < now.size() && stored[same] == now[same]) ++same;
  const auto value_in = [](const Identity& identity, const std::string& key) -> std::string {
    for (const auto& [each, value] : identity)
      if (each == key) return value;
    return "not given";
  };
  if (same == stored.size() && same == now.size()) return "";
  const std::string& key = same < now.size() ? now[same].first : stored[same].first;
  // Of two lists that differ in length, the shorter one's next key may be in both.
  const std::string before = value_in(stored, key), after = value_in(now, key);
  if (before == after && same < stored.size()) {
    const std::string& other = stored[same].first;
    return other + " is " + value_in(stored, other) + " in the checkpoint, " +
           value_in(now, other) + " now";
  }
  return key + " is " + before + " in the checkpoint, " + after + " now";
}

template Identity identity_of(const Problem<1>&, const Particles<1>&, const Formulas&);
template Identity identity_of(const Problem<2>&, const Particles<2>&, const Formulas&);
template Identity identity_of(const Problem<3>&, const Particles<3>&, const Formulas&);

}  // namespace recon::mpm
