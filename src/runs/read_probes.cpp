// The lists [[probe]].
#include <algorithm>

#include "runs/problem_reader.hpp"

namespace recon::mpm {
namespace {

using Words = std::vector<std::string>;

Words fields_of(const TomlTable& table) {
  if (!table.has("fields")) return {"displacement", "velocity", "stress"};
  return table.choices("fields", particle_fields());
}

// The kinds of probes with their keys.
template <int D>
struct ProbeKind {
  const char* name;
  Words keys;
  Probe<D> (*read)(ProblemReader<D>&, const TomlTable&);
};
template <int D>
std::vector<ProbeKind<D>> probe_kinds() {
  using Reader = ProblemReader<D>;
  return {{"particle",
           {"at", "fields"},
           [](Reader& reader, const TomlTable& table) {
             return particle_probe<D>(reader.problem(), reader.vector(table, "at"),
                                      fields_of(table));
           }},
          {"point",
           {"at", "radius", "fields"},
           [](Reader& reader, const TomlTable& table) {
             const double radius = table.number("radius", 1.5 * reader.problem().grid.h());
             return point_probe<D>(reader.problem(), reader.vector(table, "at"), radius,
                                   fields_of(table));
           }},
          {"section",
           {"axis", "at"},
           [](Reader& reader, const TomlTable& table) {
             const Words axes{"x", "y", "z"};
             const std::string axis = table.choice("axis", std::span(axes).subspan(0, D), true);
             return section_probe<D>(reader.problem(), axis[0] - 'x', table.number("at"));
           }},
          {"reaction", {"boundary"}, [](Reader& reader, const TomlTable& table) {
             const auto count = static_cast<int>(reader.problem().boundaries.size());
             if (!table.has("boundary")) table.fail("boundary", "is missing");
             if (count == 0) table.fail("boundary", "the problem has no [[boundary]]");
             const int number = table.integer("boundary", 1, 1, count);
             return reaction_probe<D>(reader.problem(), static_cast<std::size_t>(number - 1));
           }}};
}

}  // namespace

std::vector<std::string> probe_keys() {
  Words keys{"probe.kind", "probe.name"};
  for (const ProbeKind<1>& kind : probe_kinds<1>())
    for (const std::string& key : kind.keys)
      if (const std::string full = "probe." + key;
          std::find(keys.begin(), keys.end(), full) == keys.end())
        keys.push_back(full);
  return keys;
}

template <int D>
void read_probes(ProblemReader<D>& reader) {
  std::vector<Probe<D>>& probes = reader.out().probes;
  const auto is_taken = [&](const std::string& name) {
    return std::any_of(probes.begin(), probes.end(),
                       [&](const Probe<D>& each) { return each.name == name; });
  };
  for (const TomlTable& table : reader.file().tables("probe")) {
    Words names;
    for (const ProbeKind<D>& kind : probe_kinds<D>()) names.emplace_back(kind.name);
    const std::string chosen = table.choice("kind", names, true);
    Probe<D> probe;
    for (const ProbeKind<D>& kind : probe_kinds<D>())
      if (chosen == kind.name) checked(table, "kind", [&] { probe = kind.read(reader, table); });
    if (table.has("name")) {
      probe.name = table.text("name");
      const bool plain = probe.name.find_first_not_of(
                             "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-") ==
                         std::string::npos;
      if (probe.name.empty() || !plain)
        table.fail("name", "'" + probe.name + "' must be letters, digits, _ and -");
      if (is_taken(probe.name)) table.fail("name", "'" + probe.name + "' is another probe");
    } else {
      int number = 1;
      while (is_taken(chosen + std::to_string(number))) ++number;
      probe.name = chosen + std::to_string(number);
    }
    table.finish();
    probes.push_back(std::move(probe));
  }
}

template void read_probes(ProblemReader<1>&);
template void read_probes(ProblemReader<2>&);
template void read_probes(ProblemReader<3>&);

}  // namespace recon::mpm
