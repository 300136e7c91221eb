// Options from keyword arguments, and the small objects that they are said with.
#pragma once

#include <pybind11/pybind11.h>

#include <optional>
#include <variant>

#include "python/arrays.hpp"
#include "recon/neighbourhood/neighbour_list.hpp"
#include "recon/shape/options.hpp"

namespace recon::python {

// Rules with an array of radii keep the array; the C++ rules only view theirs.
struct RadiiRule {
  py::object radii;
};
struct PairRadiiRule {
  py::object particles, targets;
  PairSupport support;
};
// A list of neighbours of the caller's, in double; `list` has the numbers of the caller's rows.
struct OwnList {
  NeighbourList<double> list;
};

// What stands for `neighbours`: a rule with the arrays that it views, or a list.
struct Neighbours {
  std::optional<NeighbourRule> rule;
  std::optional<NeighbourList<double>> list;
  std::vector<py::object> kept;
};
Neighbours neighbours_of(py::handle object, const Rows& rows);

// A list in the precision of its fit.
template <class Scalar>
NeighbourList<Scalar> list_as(NeighbourList<double> list);

struct Choice {
  Options options;
  std::optional<NeighbourList<double>> list;  // neighbours of the caller's own
  std::vector<py::object> kept;               // arrays that the options view
};

// Options from keywords. None stands for what is not said. Throws InvalidArgument for a name that
// is no option, with the nearest that are.
Choice choice_of(const py::dict& keywords, const Rows& rows);
// The same for Sources: domain, stretch, particle_weights, threads.
struct SourcesChoice {
  SourcesOptions options;
  std::vector<py::object> kept;
};
SourcesChoice sources_choice_of(const py::dict& keywords, const Rows& rows);

// A weight from its name, an object that has one, or an object with __call__(q) and derivative(q).
WeightFunction weight_function_of(py::handle object);

// The name of an enumerator: a text, or what has an attribute `name`.
std::string enumerator_name(py::handle object, const char* argument);
template <class Enumerator>
Enumerator enumerator(py::handle object, const char* argument,
                      Enumerator (*named)(std::string_view)) {
  return named(enumerator_name(object, argument));
}

// Throws InvalidArgument for what cannot be called.
void require_callable(py::handle object, const char* name);

// The Progress of a call: looks for signals (KeyboardInterrupt) and calls the function, unless it
// is None. What either raises passes through the call.
Progress progress_of(py::object callback);

// A function object whose Python part is forgotten with the interpreter's lock, wherever the last
// copy ends.
std::shared_ptr<py::object> shared(py::object object);

StructuredGrid<double> grid_of(py::handle object);
bool is_grid(py::handle object);
template <class Scalar>
StructuredGrid<Scalar> grid_as(const StructuredGrid<double>& grid);

PeriodicDomain<double> domain_of(py::handle object);

void define_options(py::module_& module);

}  // namespace recon::python
