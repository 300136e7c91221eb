#include <algorithm>
#include <array>

#include "c/handles.hpp"
#include "recon/points/make_view.hpp"

using recon::c::guarded;
using recon::c::there;
using recon::detail::throw_invalid;

recon::Options recon_options::finished() const {
  recon::Options all = named.finished();
  all.particle_weights = particle_weights;
  if (has_radii) {
    if (all.neighbours)
      throw_invalid("radii", "given", "are neighbours, as radius and nearest are: say one of them");
    all.neighbours = recon::Radii{radii};
  }
  if (tensor_components > 0) {
    if (all.neighbours)
      throw_invalid("ellipsoids", "given",
                    "are neighbours, as radius, nearest and radii are: say one of them");
    all.neighbours = recon::Ellipsoids{recon::field_of_flat(tensors, tensor_components)};
  }
  return all;
}

namespace recon::c {

template <class Scalar>
NeighbourList<Scalar> list_as(const NeighbourList<double>& list) {
  NeighbourList<Scalar> out;
  out.offsets = list.offsets;
  out.indices = list.indices;
  out.support.assign(list.support.begin(), list.support.end());
  return out;
}
template <>
NeighbourList<float> list_as(const NeighbourList<double>& list) {
  NeighbourList<float> out;
  out.offsets = list.offsets;
  out.indices = list.indices;
  for (const double support : list.support) out.support.push_back(static_cast<float>(support));
  return out;
}
template NeighbourList<double> list_as(const NeighbourList<double>&);

}  // namespace recon::c

recon_status recon_options_new(recon_options** options) {
  return recon::c::made_by(options, [] { return std::make_unique<recon_options>(); });
}

void recon_options_free(recon_options* options) {
  delete options;
}

recon_status recon_options_number(recon_options* options, const char* name, double value) {
  return guarded([&] { there(options, "options").named.set(&there(name, "name"), value); });
}

recon_status recon_options_text(recon_options* options, const char* name, const char* value) {
  return guarded([&] {
    there(options, "options")
        .named.set(&there(name, "name"), std::string_view(&there(value, "value")));
  });
}

recon_status recon_options_numbers(recon_options* options, const char* name, const double* values,
                                   size_t count) {
  return guarded([&] {
    recon_options& to = there(options, "options");
    const std::string option = &there(name, "name");
    if (count > 0) there(values, "values");
    if (option == "stretch") {
      if (count < 1 || count > recon::max_dimension)
        throw_invalid("stretch", count, "must have 1, 2 or 3 numbers, one for each axis");
      std::copy(values, values + count, to.named.options.stretch.begin());
    } else if (option == "particle_weights") {
      to.particle_weights.assign(values, values + count);
    } else if (option == "radii") {
      to.radii.assign(values, values + count);
      to.has_radii = true;
    } else {
      recon::bindings::refuse_name(
          "option", option, std::vector<std::string>{"stretch", "particle_weights", "radii"});
    }
  });
}

recon_status recon_options_periodic(recon_options* options, int axis, double lower, double upper) {
  return guarded([&] {
    recon_options& to = there(options, "options");
    recon::detail::require(axis >= 0 && axis < recon::max_dimension, "axis", axis,
                           "must be 0, 1 or 2");
    recon::PeriodicDomain<double> domain = to.named.options.domain;
    domain.lower[axis] = lower;
    domain.upper[axis] = upper;
    domain.periodic[axis] = true;
    domain.validate(recon::max_dimension);
    to.named.options.domain = domain;
  });
}

recon_status recon_options_neighbours(recon_options* options, size_t targets,
                                      const int64_t* offsets, const uint32_t* indices,
                                      const double* support) {
  return guarded([&] {
    recon_options& to = there(options, "options");
    there(offsets, "offsets");
    const auto count = offsets[targets];
    recon::detail::require(count >= 0, "the last of the offsets", count, "must not be negative");
    if (count > 0) there(indices, "indices");
    if (targets > 0) there(support, "support");
    auto list = std::make_shared<recon::NeighbourList<double>>();
    list->offsets.assign(offsets, offsets + targets + 1);
    list->indices.assign(indices, indices + count);
    list->support.assign(support, support + targets);
    to.list = std::move(list);
  });
}

recon_status recon_options_ellipsoids(recon_options* options, recon_array tensors) {
  return guarded([&] {
    recon_options& to = there(options, "options");
    const recon::FieldView<double> view = recon::c::field_of<double>(tensors, "tensors");
    to.tensors.clear();
    for (std::size_t t = 0; t < view.size(); ++t)
      for (int c = 0; c < view.components(); ++c) to.tensors.push_back(view(t, c));
    to.tensor_components = view.components();
  });
}

recon_status recon_options_progress(recon_options* options,
                                    int (*progress)(double fraction, void* context),
                                    void* context) {
  return guarded([&] {
    recon::Progress& to = there(options, "options").named.options.progress;
    to = {};
    if (progress)
      to = [progress, context](double fraction) { return progress(fraction, context) != 0; };
  });
}
