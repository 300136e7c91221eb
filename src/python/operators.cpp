#include <cmath>

#include "bindings/named_options.hpp"
#include "python/objects.hpp"
#include "recon/core/parallel.hpp"

namespace recon::python {
namespace {

using detail::throw_invalid;
using Shape = std::vector<py::ssize_t>;

template <class Map>
struct Traits;
template <class S>
struct Traits<CsrOperator<S>> {
  using Scalar = S;
  static constexpr bool is_vector = false;
};
template <class S>
struct Traits<VectorOperator<S>> {
  using Scalar = S;
  static constexpr bool is_vector = true;
};
template <class Map>
using ScalarOf = typename Traits<std::decay_t<Map>>::Scalar;
template <class Map>
constexpr bool is_vector = Traits<std::decay_t<Map>>::is_vector;

// Numbers at each target and at each particle in the shape that SciPy knows.
template <class Map>
std::size_t per_target(const Map& map) {
  if constexpr (is_vector<Map>)
    return static_cast<std::size_t>(map.outputs());
  else
    return static_cast<std::size_t>(map.blocks());
}
template <class Map>
std::size_t per_particle(const Map& map) {
  if constexpr (is_vector<Map>)
    return static_cast<std::size_t>(map.inputs());
  else
    return 1;
}

py::ssize_t product(const Shape& shape) {
  py::ssize_t n = 1;
  for (const py::ssize_t s : shape) n *= s;
  return n;
}

// The shape of a result at one target: components of the field, and then the numbers of each.
template <class Map>
Shape result_shape(const Map& map, const Shape& field) {
  Shape shape;
  if constexpr (!is_vector<Map>) shape = field;
  if (per_target(map) > 1) shape.push_back(static_cast<py::ssize_t>(per_target(map)));
  return shape;
}

// The shape of a result of the transpose at one particle.
template <class Map>
Shape transposed_shape(const Map& map, const Shape& field) {
  Shape shape = field;
  const auto numbers = static_cast<py::ssize_t>(per_target(map));
  if (numbers > 1) {
    if (shape.empty() || shape.back() != numbers)
      throw_invalid("last axis of the field", shape.empty() ? 1 : shape.back(),
                    "must be " + std::to_string(numbers) +
                        ", the numbers that the operator has at each target");
    shape.pop_back();
  }
  if constexpr (is_vector<Map>) {
    if (product(shape) != 1)
      throw_invalid("components of the field", product(field),
                    "must be those at one target: " + std::to_string(numbers));
    shape = {static_cast<py::ssize_t>(map.inputs())};
  }
  return shape;
}

py::object apply(const PyOperator& op, py::handle object, py::handle out) {
  return std::visit(
      [&](const auto& map) -> py::object {
        using Scalar = ScalarOf<decltype(map)>;
        const Rows targets{map.rows(), nullptr};
        const Rows& in = op.transposed ? targets : op.rows;
        const Field<Scalar> field = field_of<Scalar>(object, in);
        const std::size_t size = op.transposed ? map.columns() : map.rows();
        const Shape shape =
            op.transposed ? transposed_shape(map, field.shape) : result_shape(map, field.shape);
        if (!out.is_none() && op.transposed && op.rows.shown)
          throw_invalid("out", "given", "cannot be used where points are masked");
        py::array_t<Scalar> result =
            out.is_none() ? new_array<Scalar>(size, shape) : own_array<Scalar>(out, size, shape);
        if (!out.is_none()) require_apart(out, object);
        const auto components = static_cast<int>(product(shape));
        const FieldSpan<Scalar> span = span_of(result, std::max(components, 1));
        {
          const auto lock = op.cloud->guard.read(sources_name);
          const py::gil_scoped_release release;
          if (op.transposed)
            map.apply_transpose(field.view, span);
          else
            with_rows(op.rows, [&] { map.apply(field.view, span); });
        }
        if (op.transposed) result = to_rows(std::move(result), op.rows);
        return py::object(std::move(result));
      },
      *op.map);
}

// Products with the vectors of iterative solvers: one number after the other.
py::object vector_product(PyOperator op, py::handle vector, bool transposed) {
  op.transposed = op.transposed != transposed;
  const auto [size, numbers] = std::visit(
      [&](const auto& map) {
        return op.transposed ? std::pair(map.rows(), per_target(map))
                             : std::pair(op.rows.size, per_particle(map));
      },
      *op.map);
  py::object field = py::module_::import("numpy").attr("asarray")(vector);
  if (numbers > 1)
    field = field.attr("reshape")(size, numbers);
  else
    field = field.attr("reshape")(-1);
  return apply(op, field, py::none()).attr("reshape")(-1);
}

template <class Map>
py::tuple shape_of(const PyOperator& op, const Map& map) {
  const std::size_t rows = map.rows() * per_target(map);
  const std::size_t columns = op.rows.size * per_particle(map);
  return op.transposed ? py::make_tuple(columns, rows) : py::make_tuple(rows, columns);
}

// The sum of two operators, the second one times a factor.
PyOperator sum(const PyOperator& a, const PyOperator& b, double factor) {
  if (a.transposed != b.transposed)
    throw_invalid("operators", "one of them transposed",
                  "must both be transposed to be added, or none");
  PyOperator out = a;
  const auto lock = a.cloud->guard.read(sources_name);
  const py::gil_scoped_release release;
  out.map = std::visit(
      [&](const auto& left, const auto& right) -> std::shared_ptr<const AnyMap> {
        using Left = std::decay_t<decltype(left)>;
        if constexpr (!std::is_same_v<Left, std::decay_t<decltype(right)>>) {
          throw_invalid("operators", "of different kinds or precision",
                        "must be alike to be added");
        } else if constexpr (is_vector<Left>) {
          throw_invalid("operators", "divergence, curl or strain rate",
                        "cannot be added: they mix components");
        } else {
          Left all = left;
          if (factor < 0)
            all -= right;
          else
            all += right;
          return std::make_shared<const AnyMap>(std::move(all));
        }
      },
      *a.map, *b.map);
  return out;
}

PyOperator scaled(const PyOperator& a, double factor) {
  PyOperator out = a;
  const auto lock = a.cloud->guard.read(sources_name);
  const py::gil_scoped_release release;
  out.map = std::visit(
      [&](const auto& map) -> std::shared_ptr<const AnyMap> {
        using Map = std::decay_t<decltype(map)>;
        if constexpr (is_vector<Map>) {
          throw_invalid("operators", "divergence, curl or strain rate",
                        "cannot be scaled: scale their results");
        } else {
          Map all = map;
          all *= static_cast<ScalarOf<Map>>(factor);
          return std::make_shared<const AnyMap>(std::move(all));
        }
      },
      *a.map);
  return out;
}

// A matrix in SciPy's arrays. Rows are written in the order of the targets.
template <class Index, class Scalar>
struct Matrix {
  Array<Index> offsets, indices;
  Array<Scalar> values;
};

// Row t * blocks + b of the matrix is number b of target t.
template <class Index, class Scalar>
Matrix<Index, Scalar> matrix_of(const CsrOperator<Scalar>& op, const Rows& rows) {
  const SparsityPattern<Scalar>& pattern = op.pattern();
  pattern.require_current();
  const NeighbourList<Scalar>& list = pattern.neighbours;
  const auto blocks = static_cast<std::size_t>(op.blocks());
  Matrix<Index, Scalar> out;
  out.offsets.resize(op.rows() * blocks + 1);
  out.offsets[0] = 0;
  for (std::size_t t = 0; t < op.rows(); ++t) {
    const auto count = static_cast<Index>(list.count(pattern.row(t)));
    for (std::size_t b = 0; b < blocks; ++b) {
      const std::size_t row = t * blocks + b;
      out.offsets[row + 1] = out.offsets[row] + count;
    }
  }
  out.indices.resize(op.entries() * blocks);
  out.values.resize(op.entries() * blocks);
  const std::span<const Scalar> numbers = op.numbers();
  parallel_blocks(op.rows(), 1024, op.threads(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const auto from = static_cast<std::size_t>(list.offsets[pattern.row(t)]);
      for (std::size_t b = 0; b < blocks; ++b) {
        const auto to = static_cast<std::size_t>(out.offsets[t * blocks + b]);
        const auto count = static_cast<std::size_t>(out.offsets[t * blocks + b + 1]) - to;
        for (std::size_t i = 0; i < count; ++i) {
          const ParticleIndex particle = list.indices[from + i];
          out.indices[to + i] = static_cast<Index>(rows.shown ? (*rows.shown)[particle] : particle);
          out.values[to + i] = numbers[(from + i) * blocks + b];
        }
      }
    }
  });
  return out;
}

// Row t * outputs + i of the matrix is component i at target t, column p * inputs + c component c
// of particle p.
template <class Index, class Scalar>
Matrix<Index, Scalar> matrix_of(const VectorOperator<Scalar>& op, const Rows& rows) {
  const SparsityPattern<Scalar>& pattern = op.gradient().pattern();
  pattern.require_current();
  const NeighbourList<Scalar>& list = pattern.neighbours;
  const std::span<const Scalar> slopes = op.gradient().numbers();
  const auto axes = static_cast<std::size_t>(op.gradient().blocks());
  Matrix<Index, Scalar> out;
  const std::size_t entries = op.gradient().entries() * op.terms().size();
  out.indices.reserve(entries);
  out.values.reserve(entries);
  out.offsets.push_back(0);
  for (std::size_t t = 0; t < op.rows(); ++t) {
    const std::size_t row = pattern.row(t);
    for (int output = 0; output < op.outputs(); ++output) {
      for (std::int64_t e = list.offsets[row]; e < list.offsets[row + 1]; ++e) {
        const ParticleIndex particle = list.indices[e];
        const auto column = static_cast<Index>(rows.shown ? (*rows.shown)[particle] : particle) *
                            static_cast<Index>(op.inputs());
        for (const auto& term : op.terms()) {
          if (term.output != output) continue;
          out.indices.push_back(column + static_cast<Index>(term.component));
          out.values.push_back(
              term.factor *
              slopes[static_cast<std::size_t>(e) * axes + static_cast<std::size_t>(term.axis)]);
        }
      }
      out.offsets.push_back(static_cast<Index>(out.indices.size()));
    }
  }
  return out;
}

template <class Index, class Map>
py::object scipy_matrix(const PyOperator& op, const Map& map) {
  Matrix<Index, ScalarOf<Map>> matrix;
  {
    const auto lock = op.cloud->guard.read(sources_name);
    const py::gil_scoped_release release;
    matrix = matrix_of<Index>(map, op.rows);
  }
  const py::object csr = py::module_::import("scipy.sparse").attr("csr_matrix");
  const auto part = [](auto&& numbers) { return vector_array(std::move(numbers)); };
  py::object made =
      csr(py::make_tuple(part(std::move(matrix.values)), part(std::move(matrix.indices)),
                         part(std::move(matrix.offsets))),
          py::arg("shape") =
              py::make_tuple(map.rows() * per_target(map), op.rows.size * per_particle(map)),
          py::arg("copy") = false);
  return op.transposed ? py::object(made.attr("T")) : made;
}

py::object to_scipy(const PyOperator& op) {
  return std::visit(
      [&](const auto& map) -> py::object {
        std::size_t entries = 0;
        if constexpr (is_vector<decltype(map)>)
          entries = map.gradient().entries() * map.terms().size();
        else
          entries = map.entries() * per_target(map);
        constexpr std::size_t most = std::size_t{1} << 31;
        const bool small = entries < most && op.rows.size * per_particle(map) < most;
        return small ? scipy_matrix<std::int32_t>(op, map) : scipy_matrix<std::int64_t>(op, map);
      },
      *op.map);
}

py::tuple row_of(const PyOperator& op, std::size_t target) {
  return std::visit(
      [&](const auto& map) -> py::tuple {
        if constexpr (is_vector<decltype(map)>) {
          throw_invalid("operator", "divergence, curl or strain rate", "has no rows of its own");
        } else {
          using Scalar = ScalarOf<decltype(map)>;
          const auto lock = op.cloud->guard.read(sources_name);
          const auto row = map.row(target);
          py::array_t<std::int64_t> particles(static_cast<py::ssize_t>(row.size()));
          Shape shape;
          if (map.blocks() > 1) shape.push_back(map.blocks());
          py::array_t<Scalar> values = new_array<Scalar>(row.size(), shape);
          Scalar* to = values.mutable_data();
          for (std::size_t i = 0; i < row.size(); ++i) {
            const ParticleIndex particle = row.particle(i);
            particles.mutable_data()[i] = op.rows.shown ? (*op.rows.shown)[particle] : particle;
            for (int b = 0; b < map.blocks(); ++b) *to++ = row.value(i, b);
          }
          return py::make_tuple(particles, values);
        }
      },
      *op.map);
}

}  // namespace

PyOperator operator_of(py::handle object) {
  if (py::isinstance<PyOperator>(object)) return object.cast<PyOperator>();
  if (py::isinstance<PyFit>(object)) return values_of(object.cast<const PyFit&>());
  throw py::type_error("operators are added to operators, not to " +
                       text_of(object.get_type().attr("__name__")));
}

void define_operators(py::module_& m) {
  py::class_<PyOperator> op(m, "Operator",
                            R"(A linear map from particle data to targets, or its transpose.

``op @ u`` has a row for each target. Where the operator has one number per target and component (the
values, the Laplacian), u of shape (n,) gives (m,), and u of shape (n, k) gives (m, k). Where it has
several (D of a gradient, D (D + 1) / 2 of a Hessian: xx, xy, xz, yy, yz, zz as far as they exist), they
are the last axis: (m, D) and (m, k, D). Divergence, curl and strain rate take fields of shape (n, D).

``op.T @ f`` takes data of the targets, shaped as results are, back to particles.

Operators of one reconstruction add up: ``a + dt * b``. An operator never changes; after an update of
its Sources it is stale, and refuses to be applied.)");
  op.def_property_readonly(
        "shape",
        [](const PyOperator& o) {
          return std::visit([&](const auto& map) { return shape_of(o, map); }, *o.map);
        },
        "(rows, columns) of the matrix: numbers at all targets, numbers at all particles.")
      .def_property_readonly(
          "dtype",
          [](const PyOperator& o) {
            return std::visit(
                [](const auto& map) { return py::dtype::of<ScalarOf<decltype(map)>>(); }, *o.map);
          })
      .def_property_readonly(
          "blocks",
          [](const PyOperator& o) {
            return std::visit([](const auto& map) { return per_target(map); }, *o.map);
          },
          "Numbers at each target for each component of a field.")
      .def_property_readonly("T",
                             [](const PyOperator& o) {
                               PyOperator out = o;
                               out.transposed = !o.transposed;
                               return out;
                             })
      .def("transpose",
           [](const PyOperator& o) {
             PyOperator out = o;
             out.transposed = !o.transposed;
             return out;
           })
      .def(
          "apply",
          [](const PyOperator& o, py::object field, py::object out) {
            return apply(o, field, out);
          },
          py::arg("field"), py::arg("out") = py::none(), R"(The product with a field.

Parameters
----------
field : array_like, shape (n,) or (n, ...), or a tuple with an array for each component
out : array, optional
    Takes the result; of the shape and dtype of the result, and apart from the field.

Returns
-------
array, shape (m, ...)

Raises
------
InvalidArgument
    For another number of rows, and for a value that is not finite where it is needed, naming the
    particle and the component.)")
      .def("__matmul__",
           [](const PyOperator& o, py::object field) { return apply(o, field, py::none()); })
      .def(
          "matvec", [](const PyOperator& o, py::object x) { return vector_product(o, x, false); },
          py::arg("x"), "The product with a vector of shape[1] numbers, for SciPy's solvers.")
      .def(
          "rmatvec", [](const PyOperator& o, py::object x) { return vector_product(o, x, true); },
          py::arg("x"), "The product of the transpose with a vector of shape[0] numbers.")
      .def("__add__", [](const PyOperator& a, py::object b) { return sum(a, operator_of(b), 1); })
      .def("__sub__", [](const PyOperator& a, py::object b) { return sum(a, operator_of(b), -1); })
      .def("__neg__", [](const PyOperator& a) { return scaled(a, -1); })
      .def(
          "__mul__", [](const PyOperator& a, double factor) { return scaled(a, factor); },
          py::is_operator())
      .def(
          "__rmul__", [](const PyOperator& a, double factor) { return scaled(a, factor); },
          py::is_operator())
      .def(
          "__truediv__", [](const PyOperator& a, double divisor) { return scaled(a, 1 / divisor); },
          py::is_operator())
      .def("to_scipy", &to_scipy, R"(The operator as a scipy.sparse.csr_matrix.

Row t * blocks + b is number b of target t; columns are particles, of divergence, curl and strain rate
p * D + c for component c of particle p: shapes as arrays without gaps have them. Targets without support have empty
rows: there is no fill value. A particle may stand in a row several times (periodic images). The arrays
of the matrix are made for it, in the order of the targets, and are not copied again.)")
      .def("row", &row_of, py::arg("target"), R"(The particles of one target, and their numbers.

Returns
-------
particles : array of int64, shape (k,)
values : array, shape (k,) or (k, blocks))")
      .def_property_readonly(
          "empty_rows",
          [](const PyOperator& o) {
            return std::visit(
                [](const auto& map) -> py::array {
                  std::vector<std::int64_t> all;
                  if constexpr (is_vector<decltype(map)>) {
                    for (const auto t : map.gradient().empty_rows()) all.push_back(t);
                  } else {
                    for (const auto t : map.empty_rows()) all.push_back(t);
                  }
                  return vector_array(std::move(all));
                },
                *o.map);
          },
          "The targets without support, ascending.")
      .def("__repr__", [](const PyOperator& o) {
        return std::visit(
            [&](const auto& map) {
              return "<recon.Operator of shape " + text_of(shape_of(o, map)) + ", " +
                     text_of(py::dtype::of<ScalarOf<decltype(map)>>()) + ">";
            },
            *o.map);
      });
  op.attr("__array_ufunc__") =
      py::none();  // numpy's numbers and arrays leave products to operators
}

}  // namespace recon::python
