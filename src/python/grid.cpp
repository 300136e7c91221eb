#include "bindings/named_options.hpp"
#include "python/objects.hpp"
#include "recon/grid/reconstruct_on_grid.hpp"

namespace recon::python {
namespace {

// The numbers of a column-major matrix with a row for each node, in the shape of the grid: (nx, ny,
// nz, columns) in Fortran's order. The array owns the matrix.
template <class Matrix>
py::array on_nodes(Matrix matrix, const StructuredGrid<double>& grid) {
  using Scalar = typename Matrix::Scalar;
  auto held = std::make_unique<Matrix>(std::move(matrix));
  std::vector<py::ssize_t> shape, strides;
  auto step = static_cast<py::ssize_t>(sizeof(Scalar));
  for (int d = 0; d < grid.dimension; ++d) {
    shape.push_back(static_cast<py::ssize_t>(grid.counts[d]));
    strides.push_back(step);
    step *= shape.back();
  }
  shape.push_back(held->cols());
  strides.push_back(step);
  Scalar* const data = held->data();
  const py::capsule owner(held.get(), [](void* memory) { delete static_cast<Matrix*>(memory); });
  held.release();
  return py::array_t<Scalar>(shape, strides, data, owner);
}

py::tuple on_grid(py::handle particles, const py::list& fields, py::handle grid_object,
                  const py::dict& keywords, py::handle gradients, py::handle limit) {
  std::optional<Points> points;
  std::shared_ptr<Cloud> cloud;
  std::shared_lock<std::shared_mutex> lock;
  Precision precision = Precision::float64;
  if (py::isinstance<PySources>(particles)) {
    cloud = particles.cast<const PySources&>().cloud;
    precision = particles.cast<const PySources&>().precision();
    lock = cloud->guard.read(sources_name);
  } else {
    points = points_of(particles, "points");
    precision = points->precision();
  }
  const Rows rows = cloud ? cloud->rows : points->rows;
  const Choice choice = choice_of(keywords, rows);
  if (choice.list)
    detail::throw_invalid("neighbours", "a NeighbourList",
                          "must be a rule: lists of one's own are for recon.reconstruct");
  GridApply apply;
  if (!gradients.is_none())
    apply.gradients = enumerator(gradients, "gradients", &bindings::derivative_of);
  apply.limit = enumerator(limit, "limit", &bindings::limit_of);
  const StructuredGrid<double> grid = grid_of(grid_object);

  const auto make = [&]<class Scalar>(const Scalar&) {
    std::vector<Field<Scalar>> kept;
    std::vector<FieldView<Scalar>> views;
    for (py::handle field : fields) {
      kept.push_back(field_of<Scalar>(field, rows));
      views.push_back(kept.back().view);
    }
    const auto made = std::make_shared<BasicGridReconstruction<Scalar>>();
    {
      const py::gil_scoped_release release;
      const StructuredGrid<Scalar> own = grid_as<Scalar>(grid);
      *made = with_rows(rows, [&] {
        return points ? reconstruct_on_grid(points->as<Scalar>(), views, own, choice.options, apply)
                      : reconstruct_on_grid(std::get<BasicSources<Scalar>>(cloud->sources), views,
                                            own, choice.options, apply);
      });
    }
    py::list shapes;
    for (const Field<Scalar>& field : kept) {
      py::tuple shape(field.shape.size());
      for (std::size_t i = 0; i < field.shape.size(); ++i) shape[i] = field.shape[i];
      shapes.append(shape);
    }
    // The reports stay where they are, and values and gradients leave for their arrays.
    const std::shared_ptr<const FitReports> reports(made, &made->report());
    py::object limited = py::none();
    if (apply.limit != Limit::none) {
      std::vector<std::uint32_t> counts = made->limited().components;
      limited = vector_array(std::move(counts));
    }
    py::object slopes = py::none();
    if (apply.gradients) slopes = on_nodes(std::move(*made).gradients(), grid);
    return py::make_tuple(on_nodes(std::move(*made).values(), grid), slopes, shapes,
                          PyReports{nullptr, reports}, limited);
  };
  return precision == Precision::float32 ? make(1.0F) : make(1.0);
}

}  // namespace

void define_grid(py::module_& m) {
  m.def("on_grid", &on_grid);
}

}  // namespace recon::python
