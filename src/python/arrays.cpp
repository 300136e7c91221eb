#include "python/arrays.hpp"

#include <algorithm>
#include <cstring>

#include "python/tables.hpp"
#include "recon/core/error.hpp"

namespace recon::python {
namespace {

using detail::throw_invalid;

py::object numpy(const char* name) {
  return py::module_::import("numpy").attr(name);
}

std::string shape_text(const py::array& array) {
  return text_of(array.attr("shape"));
}

py::array any_array(py::handle object, const char* name) {
  py::array array = py::array::ensure(object);
  if (!array) throw_invalid(name, text_of(object.get_type().attr("__name__")), "must be an array");
  return array;
}

template <class Scalar>
constexpr auto bytes = static_cast<std::ptrdiff_t>(sizeof(Scalar));

// The mask of a masked array, of its shape; nothing where no entry is masked.
py::object mask_of(py::handle object) {
  if (!is_masked(object)) return py::none();
  py::object mask = numpy("ma").attr("getmaskarray")(object);
  return mask.attr("any")().cast<bool>() ? mask : py::none();
}

// Which rows have no masked entry.
std::vector<bool> rows_shown(const py::object& mask, std::size_t size) {
  std::vector<bool> shown(size, true);
  if (mask.is_none()) return shown;
  py::object by_row = mask;
  if (mask.attr("ndim").cast<int>() > 1)
    by_row = mask.attr("reshape")(size, -1).attr("any")(py::arg("axis") = 1);
  const auto flags = py::array_t<bool, py::array::c_style | py::array::forcecast>::ensure(by_row);
  for (std::size_t i = 0; i < size; ++i) shown[i] = !flags.data()[i];
  return shown;
}

py::array_t<std::int64_t> index_array(const std::vector<std::uint32_t>& rows) {
  py::array_t<std::int64_t> index(static_cast<py::ssize_t>(rows.size()));
  std::copy(rows.begin(), rows.end(), index.mutable_data());
  return index;
}

py::array taken(const py::array& array, const Rows& rows) {
  return numpy("take")(array, index_array(*rows.shown), py::arg("axis") = 0).cast<py::array>();
}

Precision precision_of_array(const py::array& array) {
  return array.itemsize() == 4 ? Precision::float32 : Precision::float64;
}

const void* address(const py::array& array, py::ssize_t axis, py::ssize_t index) {
  return static_cast<const std::byte*>(array.data()) +
         (array.size() > 0 ? array.strides(axis) * index : 0);
}

AnyPoints view_of(Precision precision, std::size_t size, int dimension,
                  const std::array<const void*, max_dimension>& base,
                  const std::array<std::ptrdiff_t, max_dimension>& stride) {
  if (precision == Precision::float32) return PointsView<float>(size, dimension, base, stride);
  return PointsView<double>(size, dimension, base, stride);
}

// One array for each axis.
Points points_of_columns(const py::tuple& columns, const char* name,
                         std::optional<Precision> precision) {
  const std::string what = std::string(name) + ", a tuple of arrays";
  if (columns.empty() || columns.size() > max_dimension)
    throw_invalid(what, columns.size(), "must have 1, 2 or 3 arrays, one for each axis");
  const auto dimension = static_cast<int>(columns.size());
  std::vector<py::array> arrays;
  bool all_float = true;
  for (py::handle column : columns) {
    arrays.push_back(real_array(column, name, precision));
    all_float = all_float && arrays.back().itemsize() == 4;
  }
  Points points;
  points.rows.size = static_cast<std::size_t>(arrays[0].ndim() == 1 ? arrays[0].shape(0) : 0);
  const Precision common = precision.value_or(all_float ? Precision::float32 : Precision::float64);
  std::vector<bool> shown(points.rows.size, true);
  for (int d = 0; d < dimension; ++d) {
    if (arrays[d].ndim() != 1)
      throw_invalid(what, shape_text(arrays[d]),
                    "must have arrays of one dimension, one for each axis");
    if (static_cast<std::size_t>(arrays[d].shape(0)) != points.rows.size)
      throw_invalid("length of a coordinate array", arrays[d].shape(0),
                    "must equal the length of the first coordinate array");
    const std::vector<bool> here = rows_shown(mask_of(columns[d]), points.rows.size);
    for (std::size_t i = 0; i < shown.size(); ++i) shown[i] = shown[i] && here[i];
    arrays[d] = real_array(arrays[d], name, common);
  }
  if (std::find(shown.begin(), shown.end(), false) != shown.end()) {
    std::vector<std::uint32_t> rows;
    for (std::size_t i = 0; i < shown.size(); ++i)
      if (shown[i]) rows.push_back(static_cast<std::uint32_t>(i));
    points.rows.shown = std::make_shared<const std::vector<std::uint32_t>>(std::move(rows));
    for (py::array& array : arrays) array = taken(array, points.rows);
  }
  std::array<const void*, max_dimension> base{};
  std::array<std::ptrdiff_t, max_dimension> stride{};
  for (int d = 0; d < dimension; ++d) {
    base[d] = arrays[d].data();
    stride[d] = arrays[d].strides(0);
    points.kept.push_back(arrays[d]);
  }
  points.view = view_of(common, points.size(), dimension, base, stride);
  return points;
}

Points points_of_table(const ParticleTable& table, py::handle object,
                       std::optional<Precision> precision) {
  Points points;
  const PointsView<double> view = table.positions();
  points.rows.size = view.size();
  if (precision == Precision::float32) {
    py::array_t<float> copy(
        {static_cast<py::ssize_t>(view.size()), static_cast<py::ssize_t>(view.dimension())});
    float* to = copy.mutable_data();
    for (std::size_t i = 0; i < view.size(); ++i)
      for (int d = 0; d < view.dimension(); ++d) *to++ = static_cast<float>(view(i, d));
    return points_of(copy, "points", precision);
  }
  points.view = view;
  points.kept.push_back(py::reinterpret_borrow<py::object>(object));
  return points;
}

}  // namespace

std::string text_of(py::handle object) {
  return py::str(object).cast<std::string>();
}

bool is_masked(py::handle object) {
  return py::isinstance(object, numpy("ma").attr("MaskedArray"));
}

py::array real_array(py::handle object, const char* name, std::optional<Precision> precision) {
  py::array array = any_array(object, name);
  const char kind = array.dtype().kind();
  const auto refuse = [&] {
    throw_invalid(name, "an array of " + text_of(array.dtype()),
                  "must be an array of real numbers");
  };
  if (kind == 'O') {  // a table of mixed columns, or a list of numbers and None
    try {
      array = numpy("asarray")(object, py::arg("dtype") = "float64").cast<py::array>();
    } catch (py::error_already_set& error) {
      if (error.matches(PyExc_KeyboardInterrupt) || error.matches(PyExc_MemoryError)) throw;
      refuse();
    }
  } else if (kind != 'f' && kind != 'i' && kind != 'u' && kind != 'b') {
    refuse();
  }
  const py::ssize_t size = array.itemsize();
  const Precision wanted = precision.value_or(
      array.dtype().kind() == 'f' && size == 4 ? Precision::float32 : Precision::float64);
  const bool as_it_is = array.dtype().kind() == 'f' &&
                        size == (wanted == Precision::float32 ? 4 : 8) &&
                        array.dtype().attr("isnative").cast<bool>() &&
                        array.attr("flags").attr("aligned").cast<bool>();
  if (as_it_is) return array;
  return array.attr("astype")(wanted == Precision::float32 ? "float32" : "float64")
      .cast<py::array>();
}

int Points::dimension() const {
  return std::visit([](const auto& points) { return points.dimension(); }, view);
}

Points points_of(py::handle object, const char* name, std::optional<Precision> precision) {
  if (py::isinstance<py::tuple>(object)) {
    // A tuple of numbers or of points is an array like any list of them.
    const auto columns = py::reinterpret_borrow<py::tuple>(object);
    bool arrays = !columns.empty();
    for (py::handle column : columns) arrays = arrays && py::hasattr(column, "__array__");
    if (arrays && py::array::ensure(columns[0]).ndim() > 0)
      return points_of_columns(columns, name, precision);
  }
  if (const ParticleTable* table = table_of(object))
    return points_of_table(*table, object, precision);
  py::array array = real_array(object, name, precision);
  if (array.ndim() != 1 && array.ndim() != 2)
    throw_invalid(name, "an array of shape " + shape_text(array),
                  "must have the shape (n, D), a row for each point, or (n,) in one dimension");
  const auto dimension = array.ndim() == 1 ? 1 : static_cast<int>(array.shape(1));
  detail::require(
      dimension >= 1 && dimension <= max_dimension, ("columns of the " + std::string(name)).c_str(),
      dimension,
      "must be 1, 2 or 3 with a row per point (pass the transpose, .T, if points are columns)");
  Points points;
  points.rows.size = static_cast<std::size_t>(array.shape(0));
  const py::object mask = mask_of(object);
  if (!mask.is_none()) {
    const std::vector<bool> shown = rows_shown(mask, points.rows.size);
    std::vector<std::uint32_t> rows;
    for (std::size_t i = 0; i < shown.size(); ++i)
      if (shown[i]) rows.push_back(static_cast<std::uint32_t>(i));
    points.rows.shown = std::make_shared<const std::vector<std::uint32_t>>(std::move(rows));
    array = taken(array.attr("view")(numpy("ndarray")).cast<py::array>(), points.rows);
  }
  std::array<const void*, max_dimension> base{};
  for (int d = 0; d < dimension; ++d)
    base[d] = array.ndim() == 1 ? array.data() : address(array, 1, d);
  const std::ptrdiff_t step = array.strides(0);
  points.view =
      view_of(precision_of_array(array), points.size(), dimension, base, {step, step, step});
  points.kept.push_back(array);
  return points;
}

Points targets_of(py::handle object, std::optional<Precision> precision) {
  Points targets = points_of(object, "targets", precision);
  if (targets.rows.shown)
    throw_invalid("targets", "an array with masked entries",
                  "must be known: leave masked ones out");
  return targets;
}

template <class Scalar>
Field<Scalar> field_of(py::handle object, const Rows& rows, const char* name) {
  const Precision precision = precision_of<Scalar>;
  Field<Scalar> field;
  py::object values = py::reinterpret_borrow<py::object>(object);
  if (py::isinstance<py::tuple>(object)) {
    const auto columns = py::reinterpret_borrow<py::tuple>(object);
    bool arrays = !columns.empty();
    for (py::handle column : columns)
      arrays = arrays && py::hasattr(column, "__array__") && any_array(column, name).ndim() == 1;
    if (arrays) {
      // Arrays of one kind are read where they lie; others become the columns of one array.
      std::vector<py::array> parts;
      bool alike =
          columns.size() <= static_cast<std::size_t>(FieldView<Scalar>::most_arrays) && !rows.shown;
      for (py::handle column : columns) {
        parts.push_back(real_array(column, name, precision));
        alike = alike && parts.back().shape(0) == parts.front().shape(0) &&
                parts.back().strides(0) == parts.front().strides(0) && !is_masked(column);
      }
      if (alike) {
        std::vector<const Scalar*> first;
        for (const py::array& part : parts) {
          first.push_back(static_cast<const Scalar*>(part.data()));
          field.kept.push_back(part);
        }
        field.view = FieldView<Scalar>(static_cast<std::size_t>(parts[0].shape(0)),
                                       static_cast<int>(parts.size()), first, parts[0].strides(0));
        field.shape = {static_cast<py::ssize_t>(parts.size())};
        return field;
      }
      for (const py::array& part : parts)
        if (part.shape(0) != parts[0].shape(0))
          throw_invalid(name,
                        "arrays of " + std::to_string(parts[0].shape(0)) + " and " +
                            std::to_string(part.shape(0)) + " numbers",
                        "must have components of one length");
      values = numpy("ma").attr("stack")(columns, py::arg("axis") = 1);
    }
  }
  py::array array = real_array(values, name, precision);
  if (array.ndim() == 0)
    throw_invalid(name, text_of(values), "must be an array with a row for each point");
  const auto size = static_cast<std::size_t>(array.shape(0));
  const py::object mask = mask_of(values);
  if (!mask.is_none() || rows.shown) {
    if (rows.shown && size != rows.size)
      throw_invalid(
          "rows of the " + std::string(name), size,
          "must be one for each point, those that are masked too: " + std::to_string(rows.size));
    const std::vector<bool> shown = rows_shown(mask, size);
    const auto require_shown = [&](std::size_t row) {
      if (!shown[row])
        throw_invalid(name, "masked in row " + std::to_string(row),
                      "must have a value wherever its point is not masked");
    };
    array = array.attr("view")(numpy("ndarray")).cast<py::array>();
    if (rows.shown) {
      for (const std::uint32_t row : *rows.shown) require_shown(row);
      array = taken(array, rows);
    } else {
      for (std::size_t row = 0; row < size; ++row) require_shown(row);
    }
  }
  py::ssize_t components = 1;
  for (py::ssize_t axis = 1; axis < array.ndim(); ++axis) {
    field.shape.push_back(array.shape(axis));
    components *= array.shape(axis);
  }
  if (array.ndim() > 2) array = array.attr("reshape")(array.shape(0), components).cast<py::array>();
  field.view = FieldView<Scalar>(static_cast<std::size_t>(array.shape(0)),
                                 static_cast<int>(components), array.data(), array.strides(0),
                                 array.ndim() == 1 ? bytes<Scalar> : array.strides(1));
  field.kept.push_back(array);
  return field;
}

py::array_t<double> numbers_of(py::handle object, const char* name, const Rows* rows) {
  py::array array = real_array(object, name, Precision::float64);
  if (array.ndim() != 1)
    throw_invalid(name, "an array of shape " + shape_text(array), "must have one dimension");
  if (rows && rows->shown) {
    if (static_cast<std::size_t>(array.shape(0)) != rows->size)
      throw_invalid(name, "an array of " + std::to_string(array.shape(0)),
                    "must have one number for each point, those that are masked too: " +
                        std::to_string(rows->size));
    array = taken(array.attr("view")(numpy("ndarray")).cast<py::array>(), *rows);
  } else if (!mask_of(object).is_none()) {
    throw_invalid(name, "an array with masked entries", "must be known");
  }
  return py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(array);
}

template <class Scalar>
py::array_t<Scalar> new_array(std::size_t size, const std::vector<py::ssize_t>& shape) {
  std::vector<py::ssize_t> all{static_cast<py::ssize_t>(size)};
  all.insert(all.end(), shape.begin(), shape.end());
  return py::array_t<Scalar>(all);
}

template <class Scalar>
py::array_t<Scalar> own_array(py::handle out, std::size_t size,
                              const std::vector<py::ssize_t>& shape) {
  py::tuple wanted(1 + shape.size());
  wanted[0] = size;
  for (std::size_t i = 0; i < shape.size(); ++i) wanted[i + 1] = shape[i];
  if (!py::isinstance<py::array_t<Scalar>>(out) || is_masked(out))
    throw_invalid("out", text_of(out.get_type().attr("__name__")),
                  "must be an array of " + text_of(py::dtype::of<Scalar>()));
  auto array = py::reinterpret_borrow<py::array_t<Scalar>>(out);
  if (!py::tuple(array.attr("shape")).equal(wanted))
    throw_invalid("out", "an array of shape " + shape_text(array),
                  "must have the shape of the result, " + text_of(wanted));
  if (!array.writeable()) throw_invalid("out", "a read-only array", "must be writeable");
  if (!array.attr("flags").attr("aligned").template cast<bool>() ||
      (array.ndim() > 2 && !(array.flags() & py::array::c_style)))
    throw_invalid("out", "an array with gaps",
                  "must be aligned and, beyond two axes, without gaps");
  return array;
}

template <class Scalar>
FieldSpan<Scalar> span_of(py::array_t<Scalar>& out, int components) {
  const auto size = static_cast<std::size_t>(out.shape(0));
  const bool flat = out.ndim() == 2;
  return {size, components, static_cast<void*>(out.mutable_data()), out.strides(0),
          flat ? out.strides(1) : bytes<Scalar>};
}

void require_apart(py::handle out, py::handle field) {
  const auto overlap = [&](py::handle one) {
    if (py::isinstance<py::array>(one) && numpy("may_share_memory")(out, one).cast<bool>())
      throw_invalid("out", "memory of the field", "must not overlap the field");
  };
  overlap(field);
  if (py::isinstance<py::tuple>(field))
    for (py::handle column : py::reinterpret_borrow<py::tuple>(field)) overlap(column);
}

template <class Scalar>
py::array_t<Scalar> to_rows(py::array_t<Scalar> particles, const Rows& rows) {
  if (!rows.shown) return particles;
  std::vector<py::ssize_t> shape;
  std::size_t numbers = 1;
  for (py::ssize_t axis = 1; axis < particles.ndim(); ++axis) {
    shape.push_back(particles.shape(axis));
    numbers *= static_cast<std::size_t>(particles.shape(axis));
  }
  py::array_t<Scalar> all = new_array<Scalar>(rows.size, shape);
  Scalar* const to = all.mutable_data();
  std::fill(to, to + rows.size * numbers, Scalar(0));
  const Scalar* from = particles.data();
  for (const std::uint32_t row : *rows.shown) {
    std::copy(from, from + numbers, to + row * numbers);
    from += numbers;
  }
  return all;
}

#define RECON_PYTHON_ARRAYS(Scalar)                                                     \
  template Field<Scalar> field_of(py::handle, const Rows&, const char*);                \
  template py::array_t<Scalar> new_array(std::size_t, const std::vector<py::ssize_t>&); \
  template py::array_t<Scalar> own_array(py::handle, std::size_t,                       \
                                         const std::vector<py::ssize_t>&);              \
  template FieldSpan<Scalar> span_of(py::array_t<Scalar>&, int);                        \
  template py::array_t<Scalar> to_rows(py::array_t<Scalar>, const Rows&);
RECON_PYTHON_ARRAYS(float)
RECON_PYTHON_ARRAYS(double)
#undef RECON_PYTHON_ARRAYS

}  // namespace recon::python
