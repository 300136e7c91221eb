// NumPy arrays as views, and results as arrays.
//
// Arrays of float64 and float32 are read where they lie, whatever their strides. Others (integers,
// other byte orders, columns of mixed tables) are converted to float64, which is a copy; so is what
// has another precision than the object that it is for. Masked points are left out: `Rows`
// remembers which rows of the caller's arrays are particles.
//
// Everything here needs the interpreter's lock. What is made here keeps the arrays that it views.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "recon/core/error.hpp"
#include "recon/points/view.hpp"

namespace recon::python {

namespace py = pybind11;

enum class Precision { float32, float64 };
template <class Scalar>
constexpr Precision precision_of = sizeof(Scalar) == 4 ? Precision::float32 : Precision::float64;

// Which rows of the caller's arrays are particles: all, or those that are not masked.
struct Rows {
  std::size_t size = 0;  // of the caller's arrays
  std::shared_ptr<const std::vector<std::uint32_t>> shown;

  std::size_t particles() const { return shown ? shown->size() : size; }
};

// Calls what speaks of particles by their numbers. Where rows are hidden, what it throws says that
// these are not the caller's.
template <class Call>
auto with_rows(const Rows& rows, Call&& call) {
  if (!rows.shown) return call();
  try {
    return call();
  } catch (const InvalidArgument& error) {
    throw InvalidArgument(error.argument(), error.value(),
                          error.rule() + " (particles are counted without the masked ones)");
  }
}

using AnyPoints = std::variant<PointsView<float>, PointsView<double>>;

struct Points {
  AnyPoints view;
  Rows rows;
  std::vector<py::object> kept;

  std::size_t size() const { return rows.particles(); }
  int dimension() const;
  Precision precision() const {
    return view.index() == 0 ? Precision::float32 : Precision::float64;
  }
  template <class Scalar>
  const PointsView<Scalar>& as() const {
    return std::get<PointsView<Scalar>>(view);
  }
};

// Points from an array of shape (n,) or (n, D), a tuple with an array for each axis, or a
// ParticleTable, in this precision or, without one, in their own. `name` is what messages call
// them. Throws InvalidArgument for other shapes and for what holds no numbers.
Points points_of(py::handle object, const char* name, std::optional<Precision> precision = {});

// As above for targets, which cannot be masked.
Points targets_of(py::handle object, std::optional<Precision> precision = {});

template <class Scalar>
struct Field {
  FieldView<Scalar> view;
  std::vector<py::ssize_t> shape;  // of the value at one point: () for a number
  std::vector<py::object> kept;
};

// A field from an array of shape (n, ...) or a tuple with an array for each component. `rows` says
// what the points are that it belongs to. Throws InvalidArgument for an array of no numbers, for
// another length where rows are hidden, and for a value that is masked where its point is not.
template <class Scalar>
Field<Scalar> field_of(py::handle object, const Rows& rows, const char* name = "field");

// A one-dimensional array of float64 without gaps, for the particles alone where `rows` hides some.
py::array_t<double> numbers_of(py::handle object, const char* name, const Rows* rows = nullptr);

// What comes of a product: a C-ordered array of `size` rows with `shape` at each, not initialised.
template <class Scalar>
py::array_t<Scalar> new_array(std::size_t size, const std::vector<py::ssize_t>& shape);
// An array of the caller's that takes a result; throws InvalidArgument where it does not fit.
template <class Scalar>
py::array_t<Scalar> own_array(py::handle out, std::size_t size,
                              const std::vector<py::ssize_t>& shape);
// A view of a result of so many components that can be written.
template <class Scalar>
FieldSpan<Scalar> span_of(py::array_t<Scalar>& out, int components);
// Throws InvalidArgument where the two could share memory.
void require_apart(py::handle out, py::handle field);

// Rows of the particles as rows of the caller's arrays; the hidden ones are 0.
template <class Scalar>
py::array_t<Scalar> to_rows(py::array_t<Scalar> particles, const Rows& rows);

// An array that owns what was moved here. A column-major matrix becomes an array of shape (rows,
// columns) in Fortran's order.
template <class T>
py::capsule owner_of(T&& object) {
  auto held = std::make_unique<std::decay_t<T>>(std::forward<T>(object));
  py::capsule capsule(held.get(),
                      [](void* memory) { delete static_cast<std::decay_t<T>*>(memory); });
  held.release();
  return capsule;
}
template <class Vector>
py::array vector_array(Vector&& numbers) {
  using Value = typename std::decay_t<Vector>::value_type;
  auto held = std::make_unique<std::decay_t<Vector>>(std::forward<Vector>(numbers));
  Value* const data = held->data();
  const auto size = static_cast<py::ssize_t>(held->size());
  py::capsule owner(held.get(),
                    [](void* memory) { delete static_cast<std::decay_t<Vector>*>(memory); });
  held.release();
  return py::array_t<Value>(size, data, owner);
}

// "('x', 3)" and the like, for messages.
std::string text_of(py::handle object);
bool is_masked(py::handle object);
// An array of float32 or float64 in this machine's order; the same object where it is one already.
py::array real_array(py::handle object, const char* name, std::optional<Precision> precision = {});

}  // namespace recon::python
