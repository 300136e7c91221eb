#include "python/options.hpp"

#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>

#include "bindings/named_options.hpp"
#include "recon/grid/reconstruct_on_grid.hpp"

namespace recon::python {
namespace {

using detail::throw_invalid;

// A weight of the caller's: called for one q after the other, with the interpreter's lock.
struct PythonWeight {
  std::shared_ptr<py::object> function;

  double operator()(double q) const {
    const py::gil_scoped_acquire lock;
    return (*function)(q).cast<double>();
  }
  double derivative(double q) const {
    const py::gil_scoped_acquire lock;
    return function->attr("derivative")(q).cast<double>();
  }
};

std::array<double, max_dimension> axes_of(py::handle object, const char* name, double rest) {
  std::array<double, max_dimension> numbers{rest, rest, rest};
  const py::array_t<double> array = numbers_of(object, name);
  if (array.shape(0) < 1 || array.shape(0) > max_dimension)
    throw_invalid(name, array.shape(0), "must have 1, 2 or 3 numbers, one for each axis");
  for (py::ssize_t d = 0; d < array.shape(0); ++d) numbers[d] = array.at(d);
  return numbers;
}

std::span<const double> view_of(const py::array_t<double>& numbers) {
  return {numbers.data(), static_cast<std::size_t>(numbers.size())};
}

double number_of(py::handle object, const char* name) {
  const double number = PyFloat_AsDouble(object.ptr());
  if (number == -1 && PyErr_Occurred()) {
    PyErr_Clear();
    throw_invalid(name, text_of(py::repr(object)), "must be a number");
  }
  return number;
}

// An option that is a number or an enumerator.
void set_simple(bindings::NamedOptions& named, const std::string& name, py::handle value) {
  if (py::isinstance<py::str>(value)) return named.set(name, value.cast<std::string>());
  if (py::hasattr(value, "name") && py::isinstance<py::str>(value.attr("name")))
    return named.set(name, value.attr("name").cast<std::string>());
  named.set(name, number_of(value, name.c_str()));
}

template <class T>
bool set_member(py::handle object, T& to) {
  if (!py::isinstance<T>(object)) return false;
  to = object.cast<T>();
  return true;
}

std::size_t count_of(py::handle object, const char* name) {
  return bindings::whole_number(name, number_of(object, name));
}

template <class Index>
Array<Index> array_of(py::handle object, const char* name) {
  const py::array array = py::array::ensure(object);
  const bool is_whole =
      array && (array.dtype().kind() == 'i' || array.dtype().kind() == 'u' || array.size() == 0);
  if (!is_whole || array.ndim() != 1)
    throw_invalid(name, text_of(py::repr(object)).substr(0, 60),
                  "must be a one-dimensional array of integers");
  const auto numbers =
      py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>::ensure(array);
  Array<Index> out(static_cast<std::size_t>(numbers.size()));
  for (std::size_t i = 0; i < out.size(); ++i) {
    const std::int64_t number = numbers.data()[i];
    if (static_cast<std::int64_t>(static_cast<Index>(number)) != number)
      throw_invalid(std::string(name) + "[" + std::to_string(i) + "]", number,
                    "must be the number of a particle");
    out[i] = static_cast<Index>(number);
  }
  return out;
}

OwnList make_list(py::handle offsets, py::handle indices, py::handle support, py::handle shifts,
                  py::handle pair_support, double support_factor) {
  OwnList own;
  own.list.offsets = array_of<std::int64_t>(offsets, "offsets");
  own.list.indices = array_of<ParticleIndex>(indices, "indices");
  const auto fill = [](py::handle from, const char* name, Array<double>& to) {
    const py::array_t<double> numbers = numbers_of(from, name);
    to.assign(numbers.data(), numbers.data() + numbers.size());
  };
  fill(support, "support", own.list.support);
  if (!pair_support.is_none()) fill(pair_support, "pair_support", own.list.pair_support);
  if (!shifts.is_none()) {
    const auto array =
        py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>::ensure(shifts);
    if (!array || array.ndim() != 2 || array.shape(1) > max_dimension)
      throw_invalid("shifts", text_of(py::repr(shifts)).substr(0, 60),
                    "must be an array of shape (n, D) of integers");
    for (py::ssize_t i = 0; i < array.shape(0); ++i) {
      ImageShift shift{};
      for (py::ssize_t d = 0; d < array.shape(1); ++d) {
        if (std::abs(array.at(i, d)) > 127)
          throw_invalid("shifts", array.at(i, d), "must lie between -127 and 127");
        shift[d] = static_cast<std::int8_t>(array.at(i, d));
      }
      own.list.shifts.push_back(shift);
    }
  }
  own.list.support_factor = support_factor;
  return own;
}

template <class T>
py::array copy_of(const Array<T>& numbers) {
  return py::array_t<T>(static_cast<py::ssize_t>(numbers.size()), numbers.data());
}

// What Python calls the periodic domain: as many axes as it was made with.
PeriodicDomain<double> make_domain(py::handle lower, py::handle upper, py::handle periodic) {
  PeriodicDomain<double> domain;
  const py::array_t<double> low = numbers_of(lower, "lower"), high = numbers_of(upper, "upper");
  if (low.shape(0) != high.shape(0) || low.shape(0) < 1 || low.shape(0) > max_dimension)
    throw_invalid("upper", high.shape(0), "must have 1, 2 or 3 numbers, as many as lower");
  for (py::ssize_t d = 0; d < low.shape(0); ++d) {
    domain.lower[d] = low.at(d);
    domain.upper[d] = high.at(d);
    domain.periodic[d] = true;
  }
  if (!periodic.is_none()) {
    const auto flags = periodic.cast<std::vector<bool>>();
    if (static_cast<py::ssize_t>(flags.size()) != low.shape(0))
      throw_invalid("periodic", flags.size(), "must have one flag for each axis");
    for (std::size_t d = 0; d < flags.size(); ++d) domain.periodic[d] = flags[d];
  }
  domain.validate(static_cast<int>(low.shape(0)));
  return domain;
}

StructuredGrid<double> make_grid(py::handle origin, py::handle spacing, py::handle counts) {
  StructuredGrid<double> grid;
  const py::array_t<double> first = numbers_of(origin, "origin");
  if (first.shape(0) < 1 || first.shape(0) > max_dimension)
    throw_invalid("origin", first.shape(0), "must have 1, 2 or 3 coordinates");
  grid.dimension = static_cast<int>(first.shape(0));
  const py::array step = py::array::ensure(spacing);
  for (int d = 0; d < grid.dimension; ++d) grid.origin[d] = first.at(d);
  if (step && step.ndim() == 0) {
    grid.spacing.fill(number_of(spacing, "spacing"));
  } else {
    const py::array_t<double> steps = numbers_of(spacing, "spacing");
    if (steps.shape(0) != grid.dimension)
      throw_invalid("spacing", steps.shape(0), "must be one number, or one for each axis");
    for (int d = 0; d < grid.dimension; ++d) grid.spacing[d] = steps.at(d);
  }
  const py::array_t<double> numbers = numbers_of(counts, "counts");
  if (numbers.shape(0) != grid.dimension)
    throw_invalid("counts", numbers.shape(0), "must be one number of nodes for each axis");
  for (int d = 0; d < grid.dimension; ++d)
    grid.counts[d] = bindings::whole_number("counts", numbers.at(d));
  grid.validate();
  return grid;
}

template <class T>
py::tuple axes_tuple(const std::array<T, max_dimension>& numbers, int dimension) {
  py::tuple out(dimension);
  for (int d = 0; d < dimension; ++d) out[d] = numbers[d];
  return out;
}

int dimension_of(const PeriodicDomain<double>& domain) {
  int dimension = 0;
  for (int d = 0; d < max_dimension; ++d)
    if (domain.periodic[d] || domain.lower[d] != 0 || domain.upper[d] != 0) dimension = d + 1;
  return dimension;
}

}  // namespace

std::shared_ptr<py::object> shared(py::object object) {
  return {new py::object(std::move(object)), [](py::object* last) {
            if (!Py_IsInitialized()) return;  // its memory went with the interpreter
            const py::gil_scoped_acquire lock;
            delete last;
          }};
}

std::string enumerator_name(py::handle object, const char* argument) {
  if (py::isinstance<py::str>(object)) return object.cast<std::string>();
  if (py::hasattr(object, "name") && py::isinstance<py::str>(object.attr("name")))
    return object.attr("name").cast<std::string>();
  throw_invalid(argument, text_of(py::repr(object)), "must be the name of an enumerator");
}

void require_callable(py::handle object, const char* name) {
  if (!PyCallable_Check(object.ptr()))
    throw_invalid(name, text_of(py::repr(object)), "must be callable");
}

bool answer_of(const py::object& answer, const char* name) {
  if (answer.is_none())
    throw_invalid(std::string("answer of ") + name, "None", "must be True or False");
  return answer.cast<bool>();
}

Progress progress_of(py::object callback) {
  if (!callback.is_none()) require_callable(callback, "progress");
  std::shared_ptr<py::object> function;
  if (!callback.is_none()) function = shared(std::move(callback));
  return [function](double fraction) {
    const py::gil_scoped_acquire lock;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (!function) return true;
    const py::object answer = (*function)(fraction);
    return answer.is_none() || answer.cast<bool>();
  };
}

WeightFunction weight_function_of(py::handle object) {
  Gaussian gaussian;
  InverseDistance inverse;
  if (set_member(object, gaussian)) return gaussian;
  if (set_member(object, inverse)) return inverse;
  if (py::isinstance<py::str>(object) || py::hasattr(object, "name"))
    return bindings::weight_of(enumerator_name(object, "weight"));
  if (PyCallable_Check(object.ptr()) && py::hasattr(object, "derivative"))
    return PythonWeight{shared(py::reinterpret_borrow<py::object>(object))};
  throw_invalid("weight", text_of(py::repr(object)),
                "must be a name, or an object with __call__(q) and derivative(q)");
}

bool is_grid(py::handle object) {
  return py::isinstance<StructuredGrid<double>>(object);
}
StructuredGrid<double> grid_of(py::handle object) {
  return object.cast<StructuredGrid<double>>();
}

template <class Scalar>
StructuredGrid<Scalar> grid_as(const StructuredGrid<double>& grid) {
  StructuredGrid<Scalar> out;
  out.dimension = grid.dimension;
  out.counts = grid.counts;
  for (int d = 0; d < max_dimension; ++d) {
    out.origin[d] = static_cast<Scalar>(grid.origin[d]);
    out.spacing[d] = static_cast<Scalar>(grid.spacing[d]);
  }
  return out;
}
template StructuredGrid<float> grid_as(const StructuredGrid<double>&);
template StructuredGrid<double> grid_as(const StructuredGrid<double>&);

PeriodicDomain<double> domain_of(py::handle object) {
  PeriodicDomain<double> domain;
  if (!set_member(object, domain))
    throw_invalid("domain", text_of(py::repr(object)), "must be a recon.PeriodicDomain");
  return domain;
}

Neighbours neighbours_of(py::handle object, const Rows& rows) {
  Neighbours out;
  Radius radius{};
  Nearest nearest(1);
  NearestWithin within(1, 1);
  RadiiRule radii;
  PairRadiiRule pairs;
  const auto view = [&](py::handle numbers, const char* name, const Rows* of) {
    py::array_t<double> array = numbers_of(numbers, name, of);
    out.kept.push_back(array);
    return view_of(array);
  };
  if (set_member(object, radius)) {
    out.rule = radius;
  } else if (set_member(object, nearest)) {
    out.rule = nearest;
  } else if (set_member(object, within)) {
    out.rule = within;
  } else if (set_member(object, radii)) {
    out.rule = Radii{view(radii.radii, "radii", nullptr)};
  } else if (set_member(object, pairs)) {
    PairRadii rule{view(pairs.particles, "radii of the particles", &rows), {}, pairs.support};
    if (!pairs.targets.is_none())
      rule.targets = view(pairs.targets, "radii of the targets", nullptr);
    out.rule = rule;
  } else if (py::isinstance<OwnList>(object)) {
    out.list = object.cast<const OwnList&>().list;
    if (rows.shown) {  // from the caller's rows to particles
      std::vector<std::int64_t> particle(rows.size, -1);
      for (std::size_t i = 0; i < rows.shown->size(); ++i)
        particle[(*rows.shown)[i]] = static_cast<std::int64_t>(i);
      for (ParticleIndex& index : out.list->indices) {
        if (index >= rows.size || particle[index] < 0)
          throw_invalid("indices", index, "must be the numbers of points that are not masked");
        index = static_cast<ParticleIndex>(particle[index]);
      }
    }
  } else {
    throw_invalid("neighbours", text_of(py::repr(object)),
                  "must be a Radius, Radii, Nearest, NearestWithin, PairRadii or NeighbourList");
  }
  return out;
}

template <class Scalar>
NeighbourList<Scalar> list_as(NeighbourList<double> list) {
  if constexpr (std::is_same_v<Scalar, double>) {
    return list;
  } else {
    NeighbourList<Scalar> out;
    out.offsets = std::move(list.offsets);
    out.indices = std::move(list.indices);
    out.shifts = std::move(list.shifts);
    out.support_factor = static_cast<Scalar>(list.support_factor);
    for (const double support : list.support) out.support.push_back(static_cast<Scalar>(support));
    for (const double support : list.pair_support)
      out.pair_support.push_back(static_cast<Scalar>(support));
    return out;
  }
}
template NeighbourList<float> list_as(NeighbourList<double>);
template NeighbourList<double> list_as(NeighbourList<double>);

Choice choice_of(const py::dict& keywords, const Rows& rows) {
  Choice choice;
  bindings::NamedOptions named;
  Options& options = named.options;
  py::object progress = py::none();
  for (const auto& [key, value] : keywords) {
    const auto name = key.cast<std::string>();
    if (value.is_none()) {
      bindings::require_option(name);
      continue;
    }
    if (name == "neighbours") {
      Neighbours neighbours = neighbours_of(value, rows);
      options.neighbours = neighbours.rule;
      choice.list = std::move(neighbours.list);
      for (py::object& array : neighbours.kept) choice.kept.push_back(std::move(array));
      named.said(name);
    } else if (name == "weight") {
      options.weight = weight_function_of(value);
    } else if (name == "particle_weights") {
      py::array_t<double> weights = numbers_of(value, "particle_weights", &rows);
      options.particle_weights = view_of(weights);
      choice.kept.push_back(weights);
    } else if (name == "stretch") {
      options.stretch = axes_of(value, "stretch", 1);
    } else if (name == "domain") {
      options.domain = domain_of(value);
    } else if (name == "visible") {
      require_callable(value, "visible");
      const auto function = shared(py::reinterpret_borrow<py::object>(value));
      // Functions know the caller's rows.
      options.visible = [function, shown = rows.shown](std::size_t target, std::size_t particle) {
        const py::gil_scoped_acquire lock;
        return answer_of((*function)(target, shown ? (*shown)[particle] : particle), "visible");
      };
    } else if (name == "grow") {
      if (!set_member(value, options.grow)) named.set("grow.steps", number_of(value, "grow"));
    } else if (name == "tolerances") {
      if (!set_member(value, options.tolerances))
        throw_invalid(name, text_of(py::repr(value)), "must be a recon.FitTolerances");
    } else if (name == "progress") {
      progress = py::reinterpret_borrow<py::object>(value);
    } else {
      set_simple(named, name, value);
    }
  }
  options.progress = progress_of(progress);
  choice.options = named.finished();
  return choice;
}

SourcesChoice sources_choice_of(const py::dict& keywords, const Rows& rows) {
  static const std::vector<std::string> valid{"domain", "stretch", "particle_weights", "threads"};
  SourcesChoice choice;
  for (const auto& [key, value] : keywords) {
    const auto name = key.cast<std::string>();
    if (std::find(valid.begin(), valid.end(), name) == valid.end())
      bindings::refuse_name("option of Sources", name, valid);
    if (value.is_none()) continue;
    if (name == "domain") {
      choice.options.domain = domain_of(value);
    } else if (name == "stretch") {
      choice.options.stretch = axes_of(value, "stretch", 1);
    } else if (name == "threads") {
      choice.options.threads = static_cast<int>(count_of(value, "threads"));
    } else {
      py::array_t<double> weights = numbers_of(value, "particle_weights", &rows);
      choice.options.particle_weights = view_of(weights);
      choice.kept.push_back(weights);
    }
  }
  return choice;
}

void define_options(py::module_& m) {
  py::class_<Radius>(m, "Radius", R"(The particles within a radius (a length) of each target.)")
      .def(py::init([](double radius) { return Radius{radius}; }), py::arg("radius"))
      .def_readonly("radius", &Radius::radius)
      .def("__repr__",
           [](const Radius& r) { return "Radius(" + text_of(py::float_(r.radius)) + ")"; });
  py::class_<RadiiRule>(m, "Radii", R"(The particles within radii[t] (a length) of target t.)")
      .def(py::init([](py::object radii) { return RadiiRule{numbers_of(radii, "radii")}; }),
           py::arg("radii"))
      .def_readonly("radii", &RadiiRule::radii);
  py::class_<Nearest>(m, "Nearest", R"(The k nearest particles of each target.

The support radius is `factor` times the distance of the k-th.)")
      .def(py::init([](py::object k, double factor) { return Nearest(count_of(k, "k"), factor); }),
           py::arg("k"), py::arg("factor") = 1.5)
      .def_readonly("k", &Nearest::k)
      .def_readonly("factor", &Nearest::factor)
      .def("__repr__", [](const Nearest& n) {
        return "Nearest(" + std::to_string(n.k) + ", factor=" + text_of(py::float_(n.factor)) + ")";
      });
  py::class_<NearestWithin>(m, "NearestWithin",
                            R"(The k nearest of the particles within a radius (a length).)")
      .def(py::init(
               [](py::object k, double radius) { return NearestWithin(count_of(k, "k"), radius); }),
           py::arg("k"), py::arg("radius"))
      .def_readonly("k", &NearestWithin::k)
      .def_readonly("radius", &NearestWithin::radius);
  py::class_<PairRadiiRule>(m, "PairRadii",
                            R"(Supports of pairs, as in smoothed particle hydrodynamics.

Parameters
----------
particles : array_like, shape (n,)
    The radius of each particle, a length.
targets : array_like, shape (m,), optional
    The radius of each target, a length; for `support` "mean" and "larger".
support : {"particle", "mean", "larger"}
    The radius of a pair: that of the particle, the mean of both, or the larger one.)")
      .def(py::init([](py::object particles, py::object targets, py::object support) {
             return PairRadiiRule{std::move(particles), std::move(targets),
                                  enumerator(support, "support", &bindings::pair_support_of)};
           }),
           py::arg("particles"), py::arg("targets") = py::none(), py::arg("support") = "particle")
      .def_readonly("particles", &PairRadiiRule::particles)
      .def_readonly("targets", &PairRadiiRule::targets);
  py::class_<OwnList>(m, "NeighbourList", R"(Who is near whom, as a compressed sparse row list.

Parameters
----------
offsets : array_like of int, shape (m + 1,)
    The neighbours of target t are ``indices[offsets[t]:offsets[t + 1]]``.
indices : array_like of int
    Numbers of particles, counted from 0.
support : array_like, shape (m,)
    The support radius of each target, a length.
shifts : array_like of int, shape (len(indices), D), optional
    In periodic domains: which image of the particle is meant.
pair_support : array_like, optional
    The support radius of each pair, a length, one for each index.
support_factor : float
    0 where supports stand still while a target moves, else the factor of `Nearest`.)")
      .def(py::init(&make_list), py::arg("offsets"), py::arg("indices"), py::arg("support"),
           py::arg("shifts") = py::none(), py::arg("pair_support") = py::none(),
           py::arg("support_factor") = 0.0)
      .def_property_readonly("offsets",
                             [](const OwnList& own) { return copy_of(own.list.offsets); })
      .def_property_readonly(
          "indices",
          [](const OwnList& own) {
            py::array_t<std::int64_t> out(static_cast<py::ssize_t>(own.list.indices.size()));
            std::copy(own.list.indices.begin(), own.list.indices.end(), out.mutable_data());
            return out;
          })
      .def_property_readonly("support",
                             [](const OwnList& own) { return copy_of(own.list.support); })
      .def_property_readonly("pair_support",
                             [](const OwnList& own) -> py::object {
                               if (own.list.pair_support.empty()) return py::none();
                               return copy_of(own.list.pair_support);
                             })
      .def_property_readonly(
          "shifts",
          [](const OwnList& own) -> py::object {
            if (own.list.shifts.empty()) return py::none();
            py::array_t<std::int8_t> out({static_cast<py::ssize_t>(own.list.shifts.size()),
                                          static_cast<py::ssize_t>(max_dimension)});
            std::int8_t* to = out.mutable_data();
            for (const ImageShift& shift : own.list.shifts)
              for (const std::int8_t s : shift) *to++ = s;
            return out;
          })
      .def_property_readonly("support_factor",
                             [](const OwnList& own) { return own.list.support_factor; })
      .def("__len__", [](const OwnList& own) { return own.list.targets(); });

  py::class_<Growth>(
      m, "Growth",
      R"(Supports that grow: up to `steps` times by `factor`, where the degree is not reached.)")
      .def(py::init([](int steps, double factor) {
             return Growth{steps, factor};
           }),
           py::arg("steps"), py::arg("factor") = Growth{}.factor)
      .def_readonly("steps", &Growth::steps)
      .def_readonly("factor", &Growth::factor);
  py::class_<FitTolerances>(m, "FitTolerances",
                            R"(The limits below which a term or a direction counts as unresolved.)")
      .def(py::init([](double rank, double leverage, double gradient_extent) {
             return FitTolerances{rank, leverage, gradient_extent};
           }),
           py::arg("rank") = FitTolerances{}.rank, py::arg("leverage") = FitTolerances{}.leverage,
           py::arg("gradient_extent") = FitTolerances{}.gradient_extent)
      .def_readonly("rank", &FitTolerances::rank)
      .def_readonly("leverage", &FitTolerances::leverage)
      .def_readonly("gradient_extent", &FitTolerances::gradient_extent);
  py::class_<Gaussian>(m, "Gaussian",
                       R"(The weight exp(-(q / shape)^2), lowered to be 0 at q = 1.)")
      .def(py::init([](double shape) {
             Gaussian gaussian{shape};
             detail::validate_weight(gaussian);
             return gaussian;
           }),
           py::arg("shape") = Gaussian{}.shape)
      .def_readonly("shape", &Gaussian::shape);
  py::class_<InverseDistance>(m, "InverseDistance",
                              R"(The weight (1 - q)^2 / (q^2 + softening^2).)")
      .def(py::init([](double softening) {
             InverseDistance inverse{softening};
             detail::validate_weight(inverse);
             return inverse;
           }),
           py::arg("softening") = InverseDistance{}.softening)
      .def_readonly("softening", &InverseDistance::softening);

  using Domain = PeriodicDomain<double>;
  py::class_<Domain>(m, "PeriodicDomain", R"(A box whose opposite sides are one.

Parameters
----------
lower, upper : array_like, shape (D,)
    The borders along each axis, lengths.
periodic : sequence of bool, optional
    Along which axes; all by default.)")
      .def(py::init(&make_domain), py::arg("lower"), py::arg("upper"),
           py::arg("periodic") = py::none())
      .def_property_readonly("lower",
                             [](const Domain& d) { return axes_tuple(d.lower, dimension_of(d)); })
      .def_property_readonly("upper",
                             [](const Domain& d) { return axes_tuple(d.upper, dimension_of(d)); })
      .def_property_readonly(
          "periodic", [](const Domain& d) { return axes_tuple(d.periodic, dimension_of(d)); })
      .def("__repr__", [](const Domain& d) {
        const int dimension = dimension_of(d);
        return "PeriodicDomain(lower=" + text_of(axes_tuple(d.lower, dimension)) +
               ", upper=" + text_of(axes_tuple(d.upper, dimension)) +
               ", periodic=" + text_of(axes_tuple(d.periodic, dimension)) + ")";
      });

  using Grid = StructuredGrid<double>;
  py::class_<Grid>(m, "StructuredGrid", R"(A regular grid of targets.

Node (i, j, k) lies at origin + (i, j, k) * spacing; the first axis runs fastest in flat arrays.

Parameters
----------
origin : array_like, shape (D,)
    The first node, lengths.
spacing : float or array_like, shape (D,)
    The distance between nodes, a length.
counts : sequence of int, length D
    The number of nodes along each axis.)")
      .def(py::init(&make_grid), py::arg("origin"), py::arg("spacing"), py::arg("counts"))
      .def_readonly("dimension", &Grid::dimension)
      .def_property_readonly("origin",
                             [](const Grid& g) { return axes_tuple(g.origin, g.dimension); })
      .def_property_readonly("spacing",
                             [](const Grid& g) { return axes_tuple(g.spacing, g.dimension); })
      .def_property_readonly(
          "shape", [](const Grid& g) { return axes_tuple(g.counts, g.dimension); },
          "The number of nodes along each axis.")
      .def_property_readonly("counts",
                             [](const Grid& g) { return axes_tuple(g.counts, g.dimension); })
      .def_property_readonly("size", &Grid::size, "The number of nodes.")
      .def("__len__", &Grid::size)
      .def_property_readonly(
          "axes",
          [](const Grid& g) {
            py::tuple axes(g.dimension);
            for (int d = 0; d < g.dimension; ++d) {
              py::array_t<double> axis(static_cast<py::ssize_t>(g.counts[d]));
              for (std::size_t i = 0; i < g.counts[d]; ++i)
                axis.mutable_data()[i] = g.coordinate(i, d);
              axes[d] = axis;
            }
            return axes;
          },
          "The coordinates of the nodes along each axis, a tuple of arrays.")
      .def(
          "nodes",
          [](const Grid& g) {
            py::array_t<double> nodes(
                {static_cast<py::ssize_t>(g.size()), static_cast<py::ssize_t>(g.dimension)});
            double* to = nodes.mutable_data();
            for (std::size_t n = 0; n < g.size(); ++n) {
              const auto index = g.index(n);
              for (int d = 0; d < g.dimension; ++d) *to++ = g.coordinate(index[d], d);
            }
            return nodes;
          },
          "The coordinates of all nodes, an array of shape (size, D), in their flat order.")
      .def(
          "reshape",
          [](const Grid& g, py::array values) -> py::object {
            if (values.ndim() < 1 || static_cast<std::size_t>(values.shape(0)) != g.size())
              throw_invalid(
                  "values", "an array of shape " + text_of(values.attr("shape")),
                  "must have a row for each of the " + std::to_string(g.size()) + " nodes");
            py::list shape, axes;
            for (int d = g.dimension - 1; d >= 0; --d) shape.append(g.counts[d]), axes.append(d);
            for (py::ssize_t d = 1; d < values.ndim(); ++d)
              shape.append(values.shape(d)), axes.append(g.dimension + d - 1);
            return values.attr("reshape")(py::tuple(shape)).attr("transpose")(py::tuple(axes));
          },
          py::arg("values"), R"(Values of the nodes in the shape of the grid.

Parameters
----------
values : array, shape (size, ...)
    A row for each node, as ``fit @ field`` gives them.

Returns
-------
array, shape (nx, ny, nz, ...)
    As far as there are axes; ``[i, j, k]`` is node (i, j, k). A view where the rows allow it.)")
      .def(
          "__eq__",
          [](const Grid& a, const Grid& b) {
            bool same = a.dimension == b.dimension;
            for (int d = 0; same && d < a.dimension; ++d)
              same = a.origin[d] == b.origin[d] && a.spacing[d] == b.spacing[d] &&
                     a.counts[d] == b.counts[d];
            return same;
          },
          py::is_operator())
      .def("__repr__", [](const Grid& g) {
        return "StructuredGrid(origin=" + text_of(axes_tuple(g.origin, g.dimension)) +
               ", spacing=" + text_of(axes_tuple(g.spacing, g.dimension)) +
               ", counts=" + text_of(axes_tuple(g.counts, g.dimension)) + ")";
      });
  m.def(
      "covering_grid",
      [](py::object points, double spacing, py::object domain) {
        PeriodicDomain<double> periodic;
        if (!domain.is_none()) periodic = domain_of(domain);
        const Points of = points_of(points, "points", Precision::float64);
        const Box<double> box = bounding_box(of.as<double>());
        if (box.is_empty()) throw_invalid("points", 0, "must be at least one to be covered");
        return covering_grid(box, spacing, periodic);
      },
      py::arg("points"), py::arg("spacing"), py::arg("domain") = py::none(),
      R"(The grid of this spacing whose nodes lie at whole multiples of it and cover the points.

On a periodic axis the grid starts at the lower border and the spacing is shrunk so that a whole
number of cells fills the period.

Parameters
----------
points : array_like, shape (n, D)
    What is covered, lengths.
spacing : float
    The distance between nodes, a length.
domain : PeriodicDomain, optional

Returns
-------
StructuredGrid

Raises
------
InvalidArgument
    For a spacing that is not positive, or points that are not finite.)");
  m.def(
      "cell_centres", [](const Grid& grid) -> Grid { return recon::cell_centres<double>(grid); },
      py::arg("grid"),
      R"(The grid of the centres of a grid's cells: one node fewer along each axis.)");
}

}  // namespace recon::python
