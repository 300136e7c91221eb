#include "json_summary.hpp"

#include <filesystem>

#include "summary.hpp"

namespace recon::program {

namespace {

Json interval(double lower, double upper) {
  return Json::array().push(lower).push(upper);
}

}  // namespace

void set_particles(Json& object, const Particles& particles) {
  const ParticleTable& table = particles.table;
  object.set("source", table.source);
  if (table.step) object.set("step", *table.step);
  if (table.time) object.set("time", *table.time);
  if (!table.units.empty()) object.set("units", table.units);
  object.set("particles", particles.in_all).set("dimension", particles.dimension);
  Json coordinates = Json::array();
  const Box<double> extent = bounding_box(particles.positions());
  for (int d = 0; d < particles.dimension; ++d) {
    Json axis = Json::object();
    axis.set("name", particles.axes[d]);
    axis.set("least", extent.lower[d]).set("greatest", extent.upper[d]);
    axis.set("period", particles.domain.periodic[d]
                           ? interval(particles.domain.lower[d], particles.domain.upper[d])
                           : Json());
    if (table.has_box()) {
      const Box<double> box = table.box(particles.dimension);
      axis.set("box", interval(box.lower[d], box.upper[d]));
    }
    coordinates.push(axis);
  }
  object.set("coordinates", coordinates).set("notes", Json::array_of(table.remarks));
}

Json method_object(const Method& method, const FitChoice& choice, const std::string& support) {
  Json object = Json::object();
  object.set("name", method.name).set("degree", method.degree);
  object.set("weight", choice.weight).set("form", choice.form);
  object.set("weight_by", choice.weight_by.empty() ? Json() : Json(choice.weight_by));
  return object.set("support", support);
}

Json targets_object(const Targets& targets) {
  Json object = Json::object();
  object.set("count", targets.points.size()).set("description", targets.description);
  if (!targets.is_grid) return object;
  Json counts = Json::array(), origin = Json::array(), spacing = Json::array();
  for (int d = 0; d < targets.grid.dimension; ++d) {
    counts.push(targets.grid.counts[d]);
    origin.push(targets.grid.origin[d]);
    spacing.push(targets.grid.spacing[d]);
  }
  return object.set("counts", counts).set("origin", origin).set("spacing", spacing);
}

void set_fit(Json& object, const Mapped& mapped, const FitChoice& choice) {
  const FitSummary& summary = mapped.reports.summary();
  Json fit = Json::object();
  fit.set("targets", summary.targets).set("full", summary.full).set("reduced", summary.reduced);
  fit.set("nearest", summary.nearest).set("no_support", summary.no_support);
  fit.set("too_far", summary.too_far).set("handed_over", summary.handed_over);
  object.set("fit", fit);
  Json neighbours = Json::object();
  neighbours.set("least", summary.fewest_neighbours).set("mean", summary.mean_neighbours);
  object.set("neighbours", neighbours.set("most", summary.most_neighbours));
  const bool any = summary.no_support + summary.too_far + summary.nearest < summary.targets;
  Json conditioning = Json::object();
  conditioning.set("smallest_pivot", any ? Json(summary.smallest_pivot) : Json());
  conditioning.set("largest_amplification", any ? Json(summary.largest_amplification) : Json());
  object.set("conditioning", conditioning);
  Json limited = Json::object();
  limited.set("limit", choice.limit).set("values", mapped.limited.values);
  limited.set("of", mapped.values).set("targets", mapped.limited.targets);
  object.set("limited", limited);
}

Json fields_array(const FieldSet& fields) {
  Json all = Json::array();
  for (const NamedField& field : fields) {
    if (field.name == report_names().front()) break;
    for (int c = 0; c < field.components; ++c) {
      const FieldRange range = range_of(field, c);
      Json one = Json::object();
      one.set("name", field.name + component_suffix(field, c, field.components));
      one.set("least", range.least).set("greatest", range.greatest);
      all.push(one.set("missing", range.missing));
    }
  }
  return all;
}

Json files_array(const std::vector<std::string>& files) {
  Json all = Json::array();
  for (const std::string& path : files) {
    std::error_code error;
    const auto bytes = std::filesystem::file_size(path, error);
    all.push(Json::object().set("file", path).set("bytes", error ? Json() : Json(bytes)));
  }
  return all;
}

}  // namespace recon::program
