#include "field_plan.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>

#include "mapping.hpp"
#include "programs/common/errors.hpp"
#include "programs/common/text.hpp"
#include "recon/core/names.hpp"

namespace recon::program {

namespace {

using Names = std::vector<std::string>;

bool contains(const Names& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

Names velocity_columns(const Particles& particles) {
  Names columns;
  for (const char* name : {"vx", "vy", "vz"})
    if (particles.table.has(name)) columns.push_back(name);
  if (columns.size() < 3 || particles.dimension != 2) return columns;
  return {std::string("v") + particles.letters[0], std::string("v") + particles.letters[1]};
}

// The column among these that the particles have, or "".
std::string first_of(const Particles& particles, std::initializer_list<const char*> names) {
  for (const char* name : names)
    if (particles.table.has(name)) return name;
  return "";
}

std::vector<double> speeds(const Particles& particles) {
  std::vector<double> speed(particles.size(), 0.0);
  for (const char* name : {"vx", "vy", "vz"}) {
    if (!particles.table.has(name)) continue;
    const std::vector<double>& v = particles.table.column(name);
    for (std::size_t i = 0; i < v.size(); ++i) speed[i] = std::hypot(speed[i], v[i]);
  }
  return speed;
}

// Volumes of spheres, areas of discs, lengths of rods.
std::vector<double> volumes(const Particles& particles) {
  const std::string radius = first_of(particles, {"radius", "diameter"});
  const double to_radius = radius == "diameter" ? 0.5 : 1;
  std::vector<double> volume;
  for (const double value : particles.table.column(radius)) {
    const double r = value * to_radius;
    volume.push_back(particles.dimension == 3   ? 4 * std::numbers::pi / 3 * r * r * r
                     : particles.dimension == 2 ? std::numbers::pi * r * r
                                                : 2 * r);
  }
  return volume;
}

// What derived fields need; empty if these particles have it.
std::string missing_for(const std::string& derived, const Particles& particles) {
  if (derived == "speed" || derived == "velocity")
    return velocity_columns(particles).empty() ? "the columns vx, vy, vz" : "";
  if (derived == "density" && first_of(particles, {"mass", "rmass"}).empty())
    return "a column mass (number_density counts particles instead)";
  if (derived == "solid_fraction" && first_of(particles, {"radius", "diameter"}).empty())
    return "a column radius or diameter";
  return "";
}

const Names derived_names{"velocity", "speed", "density", "number_density", "solid_fraction"};

PlannedField plan_derived(Particles& particles, const std::string& name) {
  if (const std::string missing = missing_for(name, particles); !missing.empty())
    fail_usage("field " + name + " needs " + missing +
               "; the columns of the file are: " + enumeration(particles.table.names()));
  if (name == "velocity") return {name, velocity_columns(particles), {}};
  if (name == "speed") {
    particles.table.add_column(name, speeds(particles));
    return {name, {name}, {}};
  }
  if (name == "number_density") return {name, {}, std::vector<double>(particles.size(), 1.0)};
  if (name == "solid_fraction") return {name, {}, volumes(particles)};
  return {name, {}, particles.table.column(first_of(particles, {"mass", "rmass"}))};
}

[[noreturn]] void fail_unknown(const Particles& particles, const std::string& name) {
  Names known = particles.table.names();
  for (const std::string& derived : derivable_fields(particles)) known.push_back(derived);
  fail_usage("unknown field '" + name + "'; " + suggest(name, known));
}

PlannedField plan_components(const Particles& particles, const std::string& text) {
  const std::size_t equals = text.find('=');
  PlannedField field{text.substr(0, equals), {}, {}};
  if (equals != std::string::npos) field.columns = split(text.substr(equals + 1));
  if (field.name.empty() || field.columns.empty())
    fail_usage("--components " + text + ": a name and columns are needed, as in v=vx,vy,vz");
  for (const std::string& column : field.columns)
    if (!particles.table.has(column)) fail_unknown(particles, column);
  return field;
}

void plan_named(Particles& particles, const std::string& name, FieldPlan& plan) {
  if (particles.table.has(name)) {
    plan.push_back({name, {name}, {}});
  } else if (name == "all") {
    for (const std::string& column : mappable_columns(particles))
      plan.push_back({column, {column}, {}});
  } else if (contains(derived_names, name)) {
    plan.push_back(plan_derived(particles, name));
  } else if (name.empty()) {
    fail_usage("--fields has an empty name; names are separated by single commas, as in vx,vy,vz");
  } else {
    fail_unknown(particles, name);
  }
}

// Numbers, kinds, image flags and coordinates: columns that tell which particle this is, or where,
// and no field. ("xsu" is a coordinate of LAMMPS that is scaled and unwrapped.)
bool is_label(const std::string& name) {
  static const Names labels{"id",  "ids",  "gid",      "pid",     "tag",     "type",    "typelabel",
                            "mol", "proc", "procp1",   "element", "ix",      "iy",      "iz",
                            "row", "step", "timestep", "index",   "species", "material"};
  std::string lower = name;
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (contains(labels, lower) || lower.ends_with("_id") || lower.ends_with("_type")) return true;
  if (axis_of_coordinate(name)) return true;
  return lower.size() >= 2 && lower.size() <= 3 && lower[0] >= 'x' && lower[0] <= 'z' &&
         (lower.substr(1) == "s" || lower.substr(1) == "u" || lower.substr(1) == "su");
}

void require_distinct(const FieldPlan& plan) {
  Names names = report_names();
  const std::size_t reports = names.size();
  for (const PlannedField& field : plan) {
    const auto at = std::find(names.begin(), names.end(), field.name);
    if (at != names.end())
      fail_usage(at - names.begin() < static_cast<std::ptrdiff_t>(reports)
                     ? "field '" + field.name +
                           "' has the name of a report that is always written; give it another one "
                           "with --components NAME=" +
                           field.name
                     : "field '" + field.name + "' is asked for twice");
    names.push_back(field.name);
  }
}

}  // namespace

Names mappable_columns(const Particles& particles) {
  Names columns;
  for (const std::string& name : particles.table.names())
    if (!is_label(name) && !contains(particles.axes, name) &&
        !contains(particles.text_elsewhere, name))
      columns.push_back(name);
  return columns;
}

Names derivable_fields(const Particles& particles) {
  Names names;
  for (const std::string& name : derived_names)
    if (!particles.table.has(name) && missing_for(name, particles).empty()) names.push_back(name);
  return names;
}

namespace {

// The columns of the particles that these fields are made of.
Names used_columns(const Particles& particles, const std::string& fields,
                   const std::vector<std::string>& components) {
  Names used;
  const auto add = [&](const std::string& name) {
    if (!name.empty() && particles.table.has(name) && !contains(used, name)) used.push_back(name);
  };
  for (const std::string& name : split(fields)) {
    add(name);
    if (particles.table.has(name)) continue;
    if (name == "all")
      for (const std::string& column : mappable_columns(particles)) add(column);
    if (name == "velocity" || name == "speed")
      for (const char* column : {"vx", "vy", "vz"}) add(column);
    if (name == "density") add(first_of(particles, {"mass", "rmass"}));
    if (name == "solid_fraction") add(first_of(particles, {"radius", "diameter"}));
  }
  for (const std::string& text : components)
    for (const std::string& column : split(text.substr(text.find('=') + 1))) add(column);
  return used;
}

}  // namespace

bool has_sums(const FieldPlan& plan) {
  return std::any_of(plan.begin(), plan.end(),
                     [](const PlannedField& field) { return field.is_kernel_sum(); });
}

FieldPlan plan_fields(Particles& particles, const std::string& fields,
                      const std::vector<std::string>& components) {
  FieldPlan plan;
  leave_out_missing(particles, used_columns(particles, fields, components));
  with_exit_code(wrong_input, [&] {
    for (const std::string& name : split(fields)) plan_named(particles, name, plan);
    for (const std::string& text : components) plan.push_back(plan_components(particles, text));
    for (const PlannedField& field : plan)
      for (const std::string& column : field.columns) particles.table.column(column);
  });
  if (plan.empty())
    fail_usage(
        "no fields to map: name them, as in --fields vx,vy,vz; the columns of the file are: " +
        enumeration(particles.table.names()));
  require_distinct(plan);
  return plan;
}

}  // namespace recon::program
