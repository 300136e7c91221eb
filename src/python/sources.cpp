#include <utility>

#include "bindings/named_options.hpp"
#include "python/objects.hpp"
#include "recon/operators/kernel_sum.hpp"

namespace recon::python {
namespace {

using detail::throw_invalid;

template <class Scalar>
using SourcesOf = BasicSources<Scalar>;

PySources make_sources(py::handle object, const py::dict& keywords) {
  const Points points = points_of(object, "points");
  const SourcesChoice choice = sources_choice_of(keywords, points.rows);
  PySources made{std::make_shared<Cloud>()};
  made.cloud->rows = points.rows;
  const py::gil_scoped_release release;
  with_rows(points.rows, [&] {
    std::visit(
        [&](const auto& view) {
          using Scalar = typename std::decay_t<decltype(view)>::scalar_type;
          made.cloud->sources.emplace<SourcesOf<Scalar>>(view, choice.options);
        },
        points.view);
  });
  return made;
}

// Calls with the Sources in their precision.
template <class Call>
decltype(auto) with_sources(const Cloud& cloud, Call&& call) {
  if (const auto* single = std::get_if<SourcesF>(&cloud.sources)) return call(*single);
  return call(std::get<Sources>(cloud.sources));
}

void update(PySources& self, py::handle object, py::handle weights) {
  Points points = points_of(object, "points", self.precision());
  std::optional<py::array_t<double>> numbers;
  if (!weights.is_none()) numbers = numbers_of(weights, "particle_weights", &points.rows);
  const auto lock = self.cloud->guard.write(sources_name);
  {
    const py::gil_scoped_release release;
    const auto change = [&](auto& sources, const auto& view) {
      if (numbers)
        sources.update(view, {numbers->data(), static_cast<std::size_t>(numbers->size())});
      else
        sources.update(view);
    };
    with_rows(points.rows, [&] {
      if (auto* single = std::get_if<SourcesF>(&self.cloud->sources))
        change(*single, points.as<float>());
      else
        change(std::get<Sources>(self.cloud->sources), points.as<double>());
    });
  }
  self.cloud->rows = points.rows;
}

// A rule from `neighbours`, `radius` and `nearest`.
Neighbours rule_of(py::handle neighbours, py::handle radius, py::handle nearest, const Rows& rows) {
  if (neighbours.is_none()) {
    bindings::NamedOptions named;
    if (!radius.is_none()) named.set("radius", radius.cast<double>());
    if (!nearest.is_none()) named.set("nearest", nearest.cast<double>());
    Neighbours out;
    out.rule = named.finished().neighbours;
    return out;
  }
  if (!radius.is_none() || !nearest.is_none())
    throw_invalid(radius.is_none() ? "nearest" : "radius", "given",
                  "stands for neighbours, which are given too: say one of both");
  return neighbours_of(neighbours, rows);
}

OwnList find(const PySources& self, py::handle targets_object, py::handle neighbours,
             py::handle radius, py::handle nearest, py::handle shape, py::handle search,
             int threads, py::object progress) {
  const auto lock = self.cloud->guard.read(sources_name);
  const Points targets = targets_of(targets_object, self.precision());
  const Neighbours rule = rule_of(neighbours, radius, nearest, self.cloud->rows);
  if (!rule.rule)
    throw_invalid("neighbours", "no rule",
                  "must be a rule: Radius, Radii, Nearest, NearestWithin, PairRadii, Ellipsoids, "
                  "PairEllipsoids");
  NeighbourOptions options;
  const std::string name = enumerator_name(shape, "shape");
  if (name != "ball" && name != "cube")
    bindings::refuse_name("shape", name, std::vector<std::string>{"ball", "cube"});
  options.shape = name == "ball" ? SupportShape::ball : SupportShape::cube;
  options.search = enumerator(search, "search", &bindings::search_of);
  options.threads = threads;
  options.progress = progress_of(std::move(progress));
  const Rows rows = self.cloud->rows;
  const py::gil_scoped_release release;
  return with_sources(*self.cloud, [&](const auto& sources) {
    if constexpr (std::is_same_v<std::decay_t<decltype(sources)>, SourcesF>)
      return own_list(recon::find_neighbours(sources, targets.as<float>(), *rule.rule, options),
                      rows);
    else
      return own_list(recon::find_neighbours(sources, targets.as<double>(), *rule.rule, options),
                      rows);
  });
}

PyOperator kernel(const PySources& self, py::handle targets_object, py::handle weight,
                  py::handle form, py::handle neighbours, py::handle radius, py::handle nearest,
                  py::handle search, int threads) {
  const auto lock = self.cloud->guard.read(sources_name);
  const Points targets =
      targets_of(is_grid(targets_object) ? targets_object.attr("nodes")()
                                         : py::reinterpret_borrow<py::object>(targets_object),
                 self.precision());
  const Neighbours rule = rule_of(neighbours, radius, nearest, self.cloud->rows);
  if (rule.list)
    throw_invalid("neighbours", "a NeighbourList", "must be a rule: kernel sums search themselves");
  KernelOptions options;
  options.weight = weight_function_of(weight);
  options.form = enumerator(form, "form", &bindings::form_of);
  if (rule.rule) options.support = *rule.rule;
  options.search = enumerator(search, "search", &bindings::search_of);
  options.threads = threads;
  PyOperator out{nullptr, self.cloud, self.cloud->rows, false};
  const py::gil_scoped_release release;
  out.map = with_sources(*self.cloud, [&](const auto& sources) {
    if constexpr (std::is_same_v<std::decay_t<decltype(sources)>, SourcesF>)
      return std::make_shared<const AnyMap>(kernel_operator(sources, targets.as<float>(), options));
    else
      return std::make_shared<const AnyMap>(
          kernel_operator(sources, targets.as<double>(), options));
  });
  return out;
}

}  // namespace

void define_sources(py::module_& m) {
  py::class_<PySources>(m, "Sources",
                        R"(Particles, copied, checked and ordered once, for any number of questions.

Parameters
----------
points : array_like, shape (n, D) or (n,), or a tuple of D arrays
    Coordinates, lengths. float32 and float64 are read where they lie, whatever their strides; other
    numbers are converted. Masked points are left out, and keep their rows in all results. A
    ParticleTable is taken, too.
domain : PeriodicDomain, optional
stretch : array_like, shape (D,), optional
    Along axis d a support is rho * stretch[d].
particle_weights : array_like, shape (n,), optional
    Positive numbers that multiply the weights of particles in fits: their masses, for example.
threads : int
    0: all there are. Results do not depend on it.

Raises
------
InvalidArgument
    For coordinates that are not finite, naming the point and the axis.)")
      .def(py::init([](py::object points, const py::kwargs& keywords) {
             return make_sources(points, keywords);
           }),
           py::arg("points"))
      .def("update", &update, py::arg("points"), py::arg("particle_weights") = py::none(),
           R"(The particles are where `points` says; there may be more or fewer.

Reconstructions and operators made before are stale: they raise InvalidArgument until
``Reconstruction.update``. Raises as the constructor does, and then changes nothing.)")
      .def("__len__", [](const PySources& s) { return s.cloud->rows.particles(); })
      .def_property_readonly(
          "size", [](const PySources& s) { return s.cloud->rows.particles(); },
          "The number of particles; masked points are none.")
      .def_property_readonly("dimension",
                             [](const PySources& s) {
                               const auto lock = s.cloud->guard.read(sources_name);
                               return with_sources(*s.cloud,
                                                   [](const auto& own) { return own.dimension(); });
                             })
      .def_property_readonly(
          "dtype",
          [](const PySources& s) {
            return s.precision() == Precision::float32 ? py::dtype::of<float>()
                                                       : py::dtype::of<double>();
          },
          "float32 where the points are, else float64.")
      .def_property_readonly("domain",
                             [](const PySources& s) {
                               const auto lock = s.cloud->guard.read(sources_name);
                               return with_sources(*s.cloud, [](const auto& own) {
                                 return PeriodicDomain<double>(own.domain());
                               });
                             })
      .def_property_readonly(
          "order",
          [](const PySources& s) {
            const auto lock = s.cloud->guard.read(sources_name);
            return with_sources(*s.cloud, [&](const auto& own) {
              const auto order = own.order();
              py::array_t<std::int64_t> out(static_cast<py::ssize_t>(order.size()));
              for (std::size_t i = 0; i < order.size(); ++i)
                out.mutable_data()[i] =
                    s.cloud->rows.shown ? (*s.cloud->rows.shown)[order[i]] : order[i];
              return out;
            });
          },
          "order[i] is the row of the particle that stands at place i in space.")
      .def("__repr__", [](const PySources& s) {
        return "<recon.Sources of " + std::to_string(s.cloud->rows.particles()) + " particles>";
      });
  m.def("find_neighbours", &find);
  m.def("kernel_operator", &kernel);
}

}  // namespace recon::python
