#include <pybind11/stl.h>

#include "bindings/named_options.hpp"
#include "python/objects.hpp"

namespace recon::python {
namespace {

using detail::throw_invalid;
using Shape = std::vector<py::ssize_t>;

template <class Fit>
using ScalarOf =
    std::conditional_t<std::is_same_v<std::decay_t<Fit>, ReconstructionF>, float, double>;

std::shared_ptr<PyFit> reconstruct(py::handle particles, py::handle targets_object,
                                   const py::dict& keywords) {
  auto made = std::make_shared<PyFit>();
  std::optional<Points> points;
  std::shared_lock<std::shared_mutex> lock;
  Precision precision = Precision::float64;
  if (py::isinstance<PySources>(particles)) {
    made->cloud = particles.cast<const PySources&>().cloud;
    lock = made->cloud->guard.read(sources_name);
    precision = particles.cast<const PySources&>().precision();
  } else {
    points = points_of(particles, "points");
    made->cloud = std::make_shared<Cloud>();
    made->cloud->rows = points->rows;
    precision = points->precision();
  }
  made->rows = made->cloud->rows;
  Choice choice = choice_of(keywords, made->rows);
  std::optional<Points> targets;
  if (is_grid(targets_object)) {
    made->grid = grid_of(targets_object);
    if (choice.list) targets = targets_of(targets_object.attr("nodes")(), precision);
  } else {
    targets = targets_of(targets_object);
    // Of points and targets of two kinds, neither loses digits.
    if (points && targets->precision() != precision) {
      precision = Precision::float64;
      points = points_of(particles, "points", precision);
    }
    if (targets->precision() != precision) targets = targets_of(targets_object, precision);
  }

  const py::gil_scoped_release release;
  const auto make = [&]<class Scalar>(const Scalar&) {
    using Fit = BasicReconstruction<Scalar>;
    const auto with = [&](const auto& from) {
      if (choice.list)
        made->fit.emplace<Fit>(from, targets->as<Scalar>(),
                               list_as<Scalar>(std::move(*choice.list)), choice.options);
      else if (made->grid)
        made->fit.emplace<Fit>(from, grid_as<Scalar>(*made->grid), choice.options);
      else
        made->fit.emplace<Fit>(from, targets->as<Scalar>(), choice.options);
    };
    if (points)
      with(points->as<Scalar>());
    else
      with(std::get<BasicSources<Scalar>>(made->cloud->sources));
  };
  with_rows(made->rows, [&] {
    if (precision == Precision::float32)
      make(1.0F);
    else
      make(1.0);
  });
  return made;
}

void update(PyFit& self, py::handle targets_object, py::handle neighbours_object, py::handle radius,
            py::handle nearest) {
  const auto own = self.guard.write(fit_name);
  const auto lock = self.cloud->guard.read(sources_name);
  const Rows rows = self.cloud->rows;
  Neighbours neighbours;
  if (!neighbours_object.is_none()) neighbours = neighbours_of(neighbours_object, rows);
  bindings::NamedOptions named;
  if (!radius.is_none()) named.set("radius", radius.cast<double>());
  if (!nearest.is_none()) named.set("nearest", nearest.cast<double>());
  if (!neighbours_object.is_none()) named.said("neighbours");
  if (const auto rule = named.finished().neighbours) neighbours.rule = rule;
  std::optional<StructuredGrid<double>> grid;
  std::optional<Points> targets;
  if (is_grid(targets_object)) grid = grid_of(targets_object);
  if (!grid || neighbours.rule || neighbours.list)
    targets = targets_of(
        grid ? targets_object.attr("nodes")() : py::reinterpret_borrow<py::object>(targets_object),
        self.precision());
  {
    const py::gil_scoped_release release;
    std::visit(
        [&](auto& fit) {
          using Scalar = ScalarOf<decltype(fit)>;
          if (neighbours.list)
            fit.update(targets->as<Scalar>(), list_as<Scalar>(std::move(*neighbours.list)));
          else if (neighbours.rule)
            fit.update(targets->as<Scalar>(), *neighbours.rule);
          else if (grid)
            fit.update(grid_as<Scalar>(*grid));
          else
            fit.update(targets->as<Scalar>());
        },
        self.fit);
  }
  self.rows = rows;
  self.grid = grid;
}

py::object apply(const PyFit& self, py::handle object, py::handle limit, py::handle out,
                 bool return_count, bool trusted_data) {
  const auto own = self.guard.read(fit_name);
  const auto lock = self.cloud->guard.read(sources_name);
  Apply how;
  how.limit = enumerator(limit, "limit", &bindings::limit_of);
  if (trusted_data) how.data = Data::trusted;
  LimitCount count;
  if (return_count) how.count = &count;
  return std::visit(
      [&](const auto& fit) -> py::object {
        using Scalar = ScalarOf<decltype(fit)>;
        const Field<Scalar> field = field_of<Scalar>(object, self.rows);
        const std::size_t size = fit.values().rows();
        py::array_t<Scalar> result = out.is_none() ? new_array<Scalar>(size, field.shape)
                                                   : own_array<Scalar>(out, size, field.shape);
        if (!out.is_none()) require_apart(out, object);
        const FieldSpan<Scalar> span = span_of(result, field.view.components());
        {
          const py::gil_scoped_release release;
          with_rows(self.rows, [&] { fit.apply(field.view, span, how); });
        }
        if (!return_count) return py::object(std::move(result));
        return py::make_tuple(result, vector_array(std::move(count.components)));
      },
      self.fit);
}

py::object apply_transpose(const PyFit& self, py::handle object, py::handle out) {
  const auto own = self.guard.read(fit_name);
  const auto lock = self.cloud->guard.read(sources_name);
  return std::visit(
      [&](const auto& fit) -> py::object {
        using Scalar = ScalarOf<decltype(fit)>;
        const Field<Scalar> field = field_of<Scalar>(object, {fit.values().rows(), nullptr});
        if (!out.is_none() && self.rows.shown)
          throw_invalid("out", "given", "cannot be used where points are masked");
        const std::size_t size = fit.values().columns();
        py::array_t<Scalar> result = out.is_none() ? new_array<Scalar>(size, field.shape)
                                                   : own_array<Scalar>(out, size, field.shape);
        if (!out.is_none()) require_apart(out, object);
        const FieldSpan<Scalar> span = span_of(result, field.view.components());
        {
          const py::gil_scoped_release release;
          fit.apply_transpose(field.view, span);
        }
        return py::object(to_rows(std::move(result), self.rows));
      },
      self.fit);
}

struct PyFunctional {
  AnyFunctional functional;
};

AnyFunctional functional_named(const std::string& name) {
  using F = Functional;
  if (name == "value") return F::value;
  if (name == "gradient") return F::gradient;
  if (name == "hessian") return F::hessian;
  if (name == "laplacian") return F::laplacian;
  if (name == "divergence") return F::divergence;
  if (name == "curl") return F::curl;
  if (name == "strain_rate") return F::strain_rate;
  bindings::refuse_name("functional", name,
                        std::vector<std::string>{"value", "gradient", "hessian", "laplacian",
                                                 "divergence", "curl", "strain_rate"});
}

AnyFunctional functional_of(py::handle object) {
  if (py::isinstance<PyFunctional>(object)) return object.cast<const PyFunctional&>().functional;
  if (py::isinstance<py::str>(object)) return functional_named(object.cast<std::string>());
  throw_invalid("functional", text_of(py::repr(object)), "must be a name or a recon.Functional");
}

std::vector<PyOperator> operators_of(const PyFit& self,
                                     const std::vector<AnyFunctional>& functionals) {
  const auto own = self.guard.read(fit_name);
  const auto lock = self.cloud->guard.read(sources_name);
  std::vector<PyOperator> out;
  const py::gil_scoped_release release;
  std::visit(
      [&](const auto& fit) {
        for (auto& any : fit.operators(functionals))
          std::visit(
              [&](auto& made) {
                out.push_back({std::make_shared<const AnyMap>(std::move(made)), self.cloud,
                               self.rows, false});
              },
              any);
      },
      self.fit);
  return out;
}

PyOperator one_operator(const PyFit& self, const AnyFunctional& functional) {
  return operators_of(self, {functional}).front();
}

// The transpose of the values, without a copy of them.
struct PyTransposedFit {
  std::shared_ptr<const PyFit> fit;
};

Functional::Offset offset_of(py::handle object, const char* name) {
  Functional::Offset offset{};
  const py::array_t<double> numbers = numbers_of(object, name);
  if (numbers.shape(0) > max_dimension)
    throw_invalid(name, numbers.shape(0), "must have at most 3 numbers, one for each axis");
  for (py::ssize_t d = 0; d < numbers.shape(0); ++d) offset[d] = numbers.at(d);
  return offset;
}

PyFunctional own_functional(py::object action, int numbers, bool per_target) {
  const auto function = shared(std::move(action));
  return {Functional::own(
      numbers, [function, per_target](std::size_t target, const Functional::Powers& powers,
                                      std::span<double> out) {
        const py::gil_scoped_acquire lock;
        const auto tuple = py::make_tuple(powers[0], powers[1], powers[2]);
        const py::object result = per_target ? (*function)(target, tuple) : (*function)(tuple);
        const auto array =
            py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(result);
        if (!array || static_cast<std::size_t>(array.size()) != out.size())
          throw_invalid("action of the functional", text_of(py::repr(result)),
                        "must be " + std::to_string(out.size()) + " numbers");
        std::copy(array.data(), array.data() + array.size(), out.begin());
      })};
}

template <class Call>
auto reading(const PyFit& fit, Call&& call) {
  const auto own = fit.guard.read(fit_name);
  const auto lock = fit.cloud->guard.read(sources_name);
  return std::visit(call, fit.fit);
}

py::tuple shape_of(const PyFit& fit) {
  return reading(
      fit, [&](const auto& own) { return py::make_tuple(own.values().rows(), fit.rows.size); });
}

}  // namespace

PyOperator values_of(const PyFit& fit) {
  return reading(fit, [&](const auto& own) {
    return PyOperator{std::make_shared<const AnyMap>(own.values()), fit.cloud, fit.rows, false};
  });
}

void define_reconstruction(py::module_& m) {
  py::class_<PyFunctional> functional(m, "Functional",
                                      R"(What one can ask of the reconstructed field at each target.

``Functional.value``, ``gradient``, ``hessian``, ``laplacian``, ``divergence``, ``curl``, ``strain_rate``,
which ``Reconstruction.operators`` also knows by these names, and what the functions here make.)");
  functional
      .def_static(
          "partial",
          [](int nx, int ny, int nz) { return PyFunctional{Functional::partial(nx, ny, nz)}; },
          py::arg("nx"), py::arg("ny") = 0, py::arg("nz") = 0,
          "d^(nx + ny + nz) u / dx^nx dy^ny dz^nz, of order at most 4.")
      .def_static(
          "cell_average",
          [](py::object edges) {
            return PyFunctional{Functional::cell_average(offset_of(edges, "edges"))};
          },
          py::arg("edges"),
          "The average of the local polynomial over a box with these edges (lengths) about the "
          "target.")
      .def_static(
          "line_integral",
          [](py::object from, py::object to) {
            return PyFunctional{
                Functional::line_integral(offset_of(from, "from"), offset_of(to, "to"))};
          },
          py::arg("start"), py::arg("end"),
          "The integral of the local polynomial from one offset of the target to another.")
      .def_static(
          "own", &own_functional, py::arg("action"), py::arg("numbers") = 1,
          py::arg("per_target") = false,
          R"(A linear functional of the local polynomial, given by what it makes of monomials.

Parameters
----------
action : callable
    action((a, b, c)), or action(target, (a, b, c)) with `per_target`, is what the functional makes of
    (x - x_t)^a (y - y_t)^b (z - z_t)^c: a number, or `numbers` of them.)")
      .def(
          "at",
          [](const PyFunctional& f, py::object offsets) {
            const auto* plain = std::get_if<Functional>(&f.functional);
            if (!plain)
              throw_invalid("functional", "not one of one component",
                            "must be value, gradient, hessian, laplacian or partial");
            std::vector<Functional::Offset> all;
            for (py::handle offset : offsets) all.push_back(offset_of(offset, "offset"));
            return PyFunctional{plain->at(std::move(all))};
          },
          py::arg("offsets"),
          "The same of the local polynomial at these offsets (lengths) from each target.")
      .def(
          "with_slopes",
          [](const PyFunctional& f, py::object kind) {
            const Derivative slopes = enumerator(kind, "kind", &bindings::derivative_of);
            return std::visit(
                [&](const auto& own) -> PyFunctional {
                  if constexpr (std::is_same_v<std::decay_t<decltype(own)>, OwnFunctional>)
                    throw_invalid("functional", "of the local polynomial",
                                  "has diffuse slopes only");
                  else
                    return {own.with(slopes)};
                },
                f.functional);
          },
          py::arg("kind"), R"(The same with first derivatives that are "exact" or "diffuse".)");
  for (const char* name :
       {"value", "gradient", "hessian", "laplacian", "divergence", "curl", "strain_rate"})
    functional.attr(name) = PyFunctional{functional_named(name)};

  py::class_<PyFit, std::shared_ptr<PyFit>> fit(
      m, "Reconstruction",
      R"(Scattered particle data as a field at all targets: made by ``recon.reconstruct``.

``fit @ u`` is sum_p phi_p(x_t) u_p for every target t, and ``fit.T @ f`` is sum_t phi_p(x_t) f_t for every
particle p. Fields of shape (n,) give (m,), (n, k) gives (m, k), (n, 3, 3) gives (m, 3, 3). The phi_p depend
on positions only: one reconstruction serves any number of fields.)");
  fit.def("update", &update, py::arg("targets"), py::arg("neighbours") = py::none(), py::kw_only(),
          py::arg("radius") = py::none(), py::arg("nearest") = py::none(),
          R"(The same for other targets, and for the present positions of the Sources.

Parameters
----------
targets : array_like, shape (m, D), or StructuredGrid
neighbours : rule or NeighbourList, optional
    Another rule or list. A list of one's own must be given anew.
radius, nearest : optional
    Short forms of the rules Radius and Nearest.)")
      .def("apply", &apply, py::arg("field"), py::kw_only(), py::arg("limit") = "none",
           py::arg("out") = py::none(), py::arg("return_count") = false, py::arg("trusted") = false,
           R"(The reconstructed field at all targets.

Parameters
----------
field : array_like, shape (n,) or (n, ...), or a tuple with an array for each component
limit : {"none", "range", "relaxed"}
    Keeps each value in the range of the data that it is made of, or near it.
out : array, optional
    Takes the result.
return_count : bool
    Return also of how many components the limit changed the value, for each target.
trusted : bool
    The data are finite and are not looked at.

Returns
-------
array, shape (m, ...); with `return_count` a tuple of it and an array of shape (m,)

Raises
------
InvalidArgument
    For another number of rows, and for a value that is not finite where it is needed, naming the
    particle and the component.)")
      .def("apply_transpose", &apply_transpose, py::arg("field"), py::kw_only(),
           py::arg("out") = py::none(),
           "sum_t phi_p(x_t) f_t for every particle p: a row for each.")
      .def("__matmul__",
           [](const PyFit& f, py::object field) {
             return apply(f, field, py::str("none"), py::none(), false, false);
           })
      .def_property_readonly("T",
                             [](std::shared_ptr<PyFit> f) { return PyTransposedFit{std::move(f)}; })
      .def_property_readonly("shape", &shape_of, "(targets, particles)")
      .def_property_readonly("dtype",
                             [](const PyFit& f) {
                               return f.precision() == Precision::float32 ? py::dtype::of<float>()
                                                                          : py::dtype::of<double>();
                             })
      .def_property_readonly("dimension",
                             [](const PyFit& f) {
                               return reading(f, [](const auto& own) { return own.dimension(); });
                             })
      .def_property_readonly(
          "grid",
          [](const PyFit& f) {
            const auto own = f.guard.read(fit_name);
            return f.grid;
          },
          "The StructuredGrid whose nodes are the targets, or None.")
      .def_property_readonly(
          "report",
          [](std::shared_ptr<PyFit> f) {
            return PyReports{std::move(f), nullptr};
          },
          "What became of each target: a FitReports.")
      .def_property_readonly("values", &values_of,
                             "The values as an Operator: a copy, to be added to others.")
      .def(
          "gradient",
          [](const PyFit& f, py::object kind) {
            return one_operator(
                f, Functional::gradient.with(enumerator(kind, "kind", &bindings::derivative_of)));
          },
          py::arg("kind") = "exact",
          R"(The gradient of the reconstructed field, 1/length, as an Operator.

``fit.gradient() @ u`` has the shape (m, D) for u of shape (n,), and (m, k, D) for (n, k): the last axis is
d/dx, d/dy, d/dz.

Parameters
----------
kind : {"exact", "diffuse"}
    Of x -> sum_p phi_p(x) u_p, or of the local polynomial, which is cheaper.)")
      .def(
          "hessian", [](const PyFit& f) { return one_operator(f, Functional::hessian); },
          R"(Second derivatives of the local polynomial, 1/length^2: xx, xy, xz, yy, yz, zz as far as they exist.)")
      .def(
          "laplacian", [](const PyFit& f) { return one_operator(f, Functional::laplacian); },
          "sum_d d2u/dx_d^2 of each component, 1/length^2.")
      .def(
          "divergence", [](const PyFit& f) { return one_operator(f, Functional::divergence); },
          "sum_d du_d/dx_d of fields of shape (n, D): shape (m,).")
      .def(
          "curl", [](const PyFit& f) { return one_operator(f, Functional::curl); },
          "The curl of fields of shape (n, D): (m,) in 2-D, (m, 3) in 3-D.")
      .def(
          "strain_rate", [](const PyFit& f) { return one_operator(f, Functional::strain_rate); },
          "(du_a/dx_b + du_b/dx_a) / 2 of fields of shape (n, D): xx, xy, xz, yy, yz, zz as far as "
          "they exist.")
      .def(
          "operators",
          [](const PyFit& f, const py::args& functionals) {
            std::vector<AnyFunctional> all;
            for (py::handle one : functionals) all.push_back(functional_of(one));
            const std::vector<PyOperator> made = operators_of(f, all);
            py::tuple out(made.size());
            for (std::size_t i = 0; i < made.size(); ++i) out[i] = made[i];
            return out;
          },
          R"(Operators of any functionals, from one fit of each target for all of them.

``value, lap = fit.operators("value", "laplacian")``; names or objects of the class Functional.)")
      .def(
          "to_scipy", [](const PyFit& f) { return py::cast(values_of(f)).attr("to_scipy")(); },
          "The values as a scipy.sparse.csr_matrix: see Operator.to_scipy.")
      .def(
          "row",
          [](const PyFit& f, std::size_t target) {
            return py::cast(values_of(f)).attr("row")(target);
          },
          py::arg("target"), "The particles of one target and their phi_p: see Operator.row.")
      .def(
          "neighbours",
          [](const PyFit& f) {
            const auto own = f.guard.read(fit_name);
            const auto lock = f.cloud->guard.read(sources_name);
            const py::gil_scoped_release release;
            return std::visit(
                [&](const auto& reconstruction) {
                  auto list = reconstruction.neighbours();
                  OwnList out;
                  out.list.offsets = std::move(list.offsets);
                  out.list.indices = std::move(list.indices);
                  out.list.shifts = std::move(list.shifts);
                  out.list.support.assign(list.support.begin(), list.support.end());
                  out.list.pair_support.assign(list.pair_support.begin(), list.pair_support.end());
                  out.list.support_factor = static_cast<double>(list.support_factor);
                  if (f.rows.shown)
                    for (ParticleIndex& index : out.list.indices) index = (*f.rows.shown)[index];
                  return out;
                },
                f.fit);
          },
          "Who was near each target, and its support: a NeighbourList, a copy.")
      .def(
          "support",
          [](const PyFit& f) -> py::array {
            return reading(f, [](const auto& own) -> py::array {
              using Scalar = ScalarOf<decltype(own)>;
              py::array_t<Scalar> out = new_array<Scalar>(own.values().rows(), {});
              for (std::size_t t = 0; t < own.values().rows(); ++t)
                out.mutable_data()[t] = own.support(t);
              return out;
            });
          },
          "The support radius of each target, a length.")
      .def(
          "matvec",
          [](const PyFit& f, py::object x) {
            return apply(f, x.attr("reshape")(-1), py::str("none"), py::none(), false, false);
          },
          py::arg("x"), "fit @ x, for SciPy's iterative solvers.")
      .def(
          "rmatvec",
          [](const PyFit& f, py::object x) {
            return apply_transpose(f, x.attr("reshape")(-1), py::none());
          },
          py::arg("x"), "fit.T @ x, for SciPy's iterative solvers.")
      .def("__add__", [](std::shared_ptr<PyFit> f,
                         py::object b) { return py::cast(values_of(*f)).attr("__add__")(b); })
      .def("__sub__", [](std::shared_ptr<PyFit> f,
                         py::object b) { return py::cast(values_of(*f)).attr("__sub__")(b); })
      .def(
          "__mul__",
          [](const PyFit& f, double factor) {
            return py::cast(values_of(f)).attr("__mul__")(factor);
          },
          py::is_operator())
      .def(
          "__rmul__",
          [](const PyFit& f, double factor) {
            return py::cast(values_of(f)).attr("__mul__")(factor);
          },
          py::is_operator())
      .def("__repr__", [](const PyFit& f) {
        return "<recon.Reconstruction of shape " + text_of(shape_of(f)) + ">";
      });
  fit.attr("__array_ufunc__") = py::none();

  py::class_<PyTransposedFit> transposed(
      m, "TransposedReconstruction",
      R"(The transpose of a reconstruction's values: ``fit.T @ f``.)");
  transposed
      .def("__matmul__",
           [](const PyTransposedFit& t, py::object field) {
             return apply_transpose(*t.fit, field, py::none());
           })
      .def(
          "apply",
          [](const PyTransposedFit& t, py::object field, py::object out) {
            return apply_transpose(*t.fit, field, out);
          },
          py::arg("field"), py::arg("out") = py::none())
      .def_property_readonly(
          "T", [](const PyTransposedFit& t) { return std::const_pointer_cast<PyFit>(t.fit); })
      .def_property_readonly("shape",
                             [](const PyTransposedFit& t) {
                               const py::tuple shape = shape_of(*t.fit);
                               return py::make_tuple(shape[1], shape[0]);
                             })
      .def_property_readonly("dtype",
                             [](const PyTransposedFit& t) {
                               return t.fit->precision() == Precision::float32
                                          ? py::dtype::of<float>()
                                          : py::dtype::of<double>();
                             })
      .def("to_scipy",
           [](const PyTransposedFit& t) {
             return py::cast(values_of(*t.fit)).attr("to_scipy")().attr("T");
           })
      .def("__repr__", [](const PyTransposedFit& t) {
        const py::tuple shape = shape_of(*t.fit);
        return "<recon.TransposedReconstruction of shape " +
               text_of(py::make_tuple(shape[1], shape[0])) + ">";
      });
  transposed.attr("__array_ufunc__") = py::none();

  m.def("reconstruct", &reconstruct);
}

}  // namespace recon::python
