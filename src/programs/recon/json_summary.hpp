// What summary.hpp prints for a reader, as members of one JSON object for a script.
#pragma once

#include <string>
#include <vector>

#include "fit_choice.hpp"
#include "map_job.hpp"
#include "mapping.hpp"
#include "programs/common/json.hpp"

namespace recon::program {

// source, frame, step, time, units, particles, dimension, coordinates, notes.
void set_particles(Json& object, const Particles& particles);
// name, degree, weight, form, weight_by, support.
Json method_object(const Method& method, const FitChoice& choice, const std::string& support);
// count, description; of a grid also counts, origin and spacing.
Json targets_object(const Targets& targets);
// fit, neighbours, conditioning, limited.
void set_fit(Json& object, const Mapped& mapped, const FitChoice& choice);
// name, least, greatest and the number of targets without a value, for each component.
Json fields_array(const FieldSet& fields);
// file and bytes.
Json files_array(const std::vector<std::string>& files);

}  // namespace recon::program
