#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "python/objects.hpp"
#include "python/tables.hpp"
#include "recon/io/read.hpp"
#include "recon/io/write.hpp"

namespace recon::python {
namespace {

using detail::throw_invalid;

ReadOptions read_options(int frame, std::optional<std::int64_t> step, std::optional<double> time,
                         std::optional<std::vector<std::string>> columns, std::size_t skip_rows,
                         std::optional<std::vector<std::string>> missing,
                         const std::string& group = "") {
  ReadOptions options;
  options.group = group;
  options.frame = frame;
  options.step = step;
  options.time = time;
  if (columns) options.columns = std::move(*columns);
  options.skip_rows = skip_rows;
  if (missing) options.missing = std::move(*missing);
  return options;
}

using Table = std::shared_ptr<ParticleTable>;

// A column where it lies; the table lives as long.
py::array view_of(const Table& table, const std::vector<double>& column) {
  auto held = std::make_unique<Table>(table);
  const py::capsule owner(held.get(), [](void* memory) { delete static_cast<Table*>(memory); });
  held.release();
  py::array_t<double> array(static_cast<py::ssize_t>(column.size()), column.data(), owner);
  array.attr("flags").attr("writeable") = false;
  return array;
}

py::tuple box_of(const Box<double>& box) {
  py::tuple lower(box.dimension), upper(box.dimension);
  for (int d = 0; d < box.dimension; ++d) lower[d] = box.lower[d], upper[d] = box.upper[d];
  return py::make_tuple(lower, upper);
}

py::dict info_of(const FrameInfo& info) {
  py::dict out;
  out["step"] = info.step;
  out["time"] = info.time;
  out["particles"] = info.particles;
  out["columns"] = info.columns;
  out["line"] = info.line;
  out["units"] = info.units;
  return out;
}

FieldSet field_set_of(const py::dict& fields, std::size_t size, std::optional<std::int64_t> step,
                      std::optional<double> time) {
  FieldSet set;
  set.step = step;
  set.time = time;
  for (const auto& [key, value] : fields) {
    const auto name = key.cast<std::string>();
    const py::array given = py::array::ensure(value);
    const bool whole = given && (given.dtype().kind() == 'i' || given.dtype().kind() == 'u' ||
                                 given.dtype().kind() == 'b');
    const bool single = given && given.dtype().kind() == 'f' && given.itemsize() == 4;
    const Field<double> field = field_of<double>(value, {size, nullptr}, name.c_str());
    std::vector<double> values;
    values.reserve(field.view.size() * static_cast<std::size_t>(field.view.components()));
    for (std::size_t i = 0; i < field.view.size(); ++i)
      for (int c = 0; c < field.view.components(); ++c) values.push_back(field.view(i, c));
    set.add(name, field.view.components(), std::move(values),
            whole    ? NumberType::int32
            : single ? NumberType::float32
                     : NumberType::float64);
  }
  return set;
}

void write_file(const std::filesystem::path& path, py::handle where, const py::dict& fields,
                std::optional<std::int64_t> step, std::optional<double> time) {
  if (is_grid(where)) {
    const StructuredGrid<double> grid = grid_of(where);
    const FieldSet set = field_set_of(fields, grid.size(), step, time);
    const py::gil_scoped_release release;
    return recon::write(path, grid, set);
  }
  const Points points = targets_of(where, Precision::float64);
  const FieldSet set = field_set_of(fields, points.size(), step, time);
  const py::gil_scoped_release release;
  recon::write(path, points.as<double>(), set);
}

// Frames one after the other; a frame is read without the interpreter's lock.
struct PyFrames {
  FrameReader reader;
  Guard guard;
};

}  // namespace

const ParticleTable* table_of(py::handle object) {
  return py::isinstance<ParticleTable>(object) ? &object.cast<const ParticleTable&>() : nullptr;
}

void define_io(py::module_& m) {
  py::class_<ParticleTable, Table>(
      m, "ParticleTable", R"(One frame of a file: named columns, and what is known about the whole.

A mapping of names to arrays: ``table["vx"]`` is a view of the column, which cannot be written. It can stand
for points wherever these are asked for.)")
      .def("__getitem__",
           [](const Table& t, const std::string& name) { return view_of(t, t->column(name)); })
      .def(
          "raw_column",
          [](const Table& t, const std::string& name) { return view_of(t, t->raw_column(name)); },
          py::arg("name"), "A column as it is, with NaN where a cell holds no number.")
      .def("keys", [](const Table& t) { return t->names(); })
      .def("__iter__", [](const Table& t) { return py::iter(py::cast(t->names())); })
      .def("__contains__", [](const Table& t, const std::string& name) { return t->has(name); })
      .def("__len__", [](const Table& t) { return t->names().size(); })
      .def("items",
           [](const Table& t) {
             py::list items;
             for (const std::string& name : t->names())
               items.append(py::make_tuple(name, view_of(t, t->raw_column(name))));
             return items;
           })
      .def_property_readonly(
          "size", [](const Table& t) { return t->size(); }, "The number of particles.")
      .def_property_readonly("dimension", [](const Table& t) { return t->dimension(); })
      .def(
          "positions",
          [](const Table& t, int dimension) {
            const PointsView<double> view = t->positions(dimension);
            py::array_t<double> out({static_cast<py::ssize_t>(view.size()),
                                     static_cast<py::ssize_t>(view.dimension())});
            double* to = out.mutable_data();
            for (std::size_t i = 0; i < view.size(); ++i)
              for (int d = 0; d < view.dimension(); ++d) *to++ = view(i, d);
            return out;
          },
          py::arg("dimension") = 0,
          "The coordinates as an array of shape (n, D), a copy; 0: in as many dimensions as there "
          "are.")
      .def(
          "field",
          [](const Table& t, const std::vector<std::string>& columns) {
            NamedField field = t->field("field", columns);
            const auto components = static_cast<py::ssize_t>(columns.size());
            return vector_array(std::move(field.values)).attr("reshape")(-1, components);
          },
          py::arg("columns"), "Several columns as one array of shape (n, k), a copy.")
      .def(
          "coordinates", [](const Table& t, int dimension) { return t->coordinates(dimension); },
          py::arg("dimension") = 0, "The names of the columns that hold the coordinates.")
      .def(
          "with_coordinates",
          [](const Table& t, std::vector<std::string> columns) {
            auto other = std::make_shared<ParticleTable>(*t);
            other->set_coordinates(std::move(columns));
            return other;
          },
          py::arg("columns"), "The same table with these columns as coordinates.")
      .def(
          "where",
          [](const Table& t, py::array_t<bool, py::array::forcecast> kept) {
            std::vector<bool> rows;
            if (kept.ndim() != 1)
              throw_invalid("kept", kept.ndim(),
                            "must be an array of one dimension, a flag for each row");
            for (py::ssize_t i = 0; i < kept.shape(0); ++i) rows.push_back(kept.at(i));
            auto other = std::make_shared<ParticleTable>(*t);
            other->keep_rows(rows);
            return other;
          },
          py::arg("kept"), "A table of the rows whose flag is true.")
      .def(
          "without_missing",
          [](const Table& t, const std::vector<std::string>& columns) {
            auto other = std::make_shared<ParticleTable>(*t);
            other->leave_out_missing(columns);
            return other;
          },
          py::arg("columns"), "A table without the particles that have no value in these columns.")
      .def(
          "box", [](const Table& t, int dimension) { return box_of(t->box(dimension)); },
          py::arg("dimension") = 0,
          "(lower, upper) of the simulation box or, without one, of the particles.")
      .def(
          "domain", [](const Table& t, int dimension) { return t->domain(dimension); },
          py::arg("dimension") = 0, "The PeriodicDomain that the source says.")
      .def_property_readonly("text_columns", [](const Table& t) { return t->text_columns(); })
      .def_readonly("source", &ParticleTable::source)
      .def_readonly("step", &ParticleTable::step)
      .def_readonly("time", &ParticleTable::time)
      .def_readonly("units", &ParticleTable::units)
      .def_readonly("remarks", &ParticleTable::remarks)
      .def("__repr__", [](const Table& t) {
        return "<recon.ParticleTable of " + std::to_string(t->size()) + " particles, " + t->source +
               ">";
      });

  m.def("read_particles", [](const std::filesystem::path& path, int frame,
                             std::optional<std::int64_t> step, std::optional<double> time,
                             std::optional<std::vector<std::string>> columns, std::size_t skip_rows,
                             std::optional<std::vector<std::string>> missing,
                             const std::string& group) {
    const ReadOptions options =
        read_options(frame, step, time, std::move(columns), skip_rows, std::move(missing), group);
    const py::gil_scoped_release release;
    return std::make_shared<ParticleTable>(read_particles(path, options));
  });
  m.def("list_frames", [](const std::filesystem::path& path,
                          std::optional<std::vector<std::string>> columns, std::size_t skip_rows,
                          const std::string& group) {
    const ReadOptions options = read_options(-1, {}, {}, std::move(columns), skip_rows, {}, group);
    std::vector<FrameInfo> frames;
    {
      const py::gil_scoped_release release;
      frames = list_frames(path, options);
    }
    py::list out;
    for (const FrameInfo& info : frames) out.append(info_of(info));
    return out;
  });
  py::class_<PyFrames>(
      m, "FrameReader",
      R"(All frames of a file in one pass, with the memory of one: an iterator of ParticleTable.)")
      .def(py::init([](const std::filesystem::path& path,
                       std::optional<std::vector<std::string>> columns, std::size_t skip_rows,
                       std::optional<std::vector<std::string>> missing, const std::string& group) {
             const ReadOptions options =
                 read_options(-1, {}, {}, std::move(columns), skip_rows, std::move(missing), group);
             const py::gil_scoped_release release;
             return std::unique_ptr<PyFrames>(new PyFrames{FrameReader(path, options), {}});
           }),
           py::arg("path"), py::kw_only(), py::arg("columns") = py::none(),
           py::arg("skip_rows") = 0, py::arg("missing") = py::none(), py::arg("group") = "")
      .def("__iter__", [](py::object self) { return self; })
      .def("__next__",
           [](PyFrames& frames) {
             std::optional<ParticleTable> table;
             {
               const auto lock = frames.guard.write("the object FrameReader");
               const py::gil_scoped_release release;
               table = frames.reader.next();
             }
             if (!table) throw py::stop_iteration();
             return std::make_shared<ParticleTable>(std::move(*table));
           })
      .def_property_readonly(
          "cut", [](const PyFrames& frames) { return frames.reader.cut(); },
          "After the last frame: why the file ends within another one, or \"\".");
  m.def("write", &write_file);
}

}  // namespace recon::python
