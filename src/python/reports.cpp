#include <pybind11/stl.h>

#include <algorithm>
#include <sstream>

#include "bindings/named_options.hpp"
#include "python/objects.hpp"

namespace recon::python {
namespace {

using detail::throw_invalid;

// Calls with the reports, which stay while it lasts.
template <class Call>
auto reading(const PyReports& reports, Call&& call) {
  if (reports.own) return call(*reports.own);
  const auto own = reports.fit->guard.read(fit_name);
  const auto lock = reports.fit->cloud->guard.read(sources_name);
  return std::visit([&](const auto& fit) { return call(fit.report()); }, reports.fit->fit);
}

template <class T, class Member>
py::array column(const PyReports& reports, const Member& member) {
  return reading(reports, [&](const FitReports& all) -> py::array {
    py::array_t<T> out(static_cast<py::ssize_t>(all.size()));
    T* to = out.mutable_data();
    for (const FitReport& report : all.all()) *to++ = static_cast<T>(member(report));
    return out;
  });
}

py::array kept(const PyReports& reports) {
  return reading(reports, [&](const FitReports& all) -> py::array {
    py::array_t<std::uint8_t> out({static_cast<py::ssize_t>(all.size()),
                                   static_cast<py::ssize_t>(FitReport::max_degree + 1)});
    std::uint8_t* to = out.mutable_data();
    for (const FitReport& report : all.all())
      to = std::copy(report.kept.begin(), report.kept.end(), to);
    return out;
  });
}

const std::vector<std::string>& names() {
  static const std::vector<std::string> all{"neighbours",
                                            "rank",
                                            "degree",
                                            "status",
                                            "solver",
                                            "gradient_rank",
                                            "hessian_rank",
                                            "kept",
                                            "smallest_pivot",
                                            "amplification",
                                            "gradient_amplification"};
  return all;
}

py::array column_named(const PyReports& r, const std::string& name) {
  if (name == "neighbours")
    return column<std::uint32_t>(r, [](const FitReport& f) { return f.neighbours; });
  if (name == "rank") return column<std::uint8_t>(r, [](const FitReport& f) { return f.rank; });
  if (name == "degree") return column<std::int8_t>(r, [](const FitReport& f) { return f.degree; });
  if (name == "status") return column<std::uint8_t>(r, [](const FitReport& f) { return f.status; });
  if (name == "solver") return column<std::uint8_t>(r, [](const FitReport& f) { return f.solver; });
  if (name == "gradient_rank")
    return column<std::uint8_t>(r, [](const FitReport& f) { return f.gradient_rank; });
  if (name == "hessian_rank")
    return column<std::uint8_t>(r, [](const FitReport& f) { return f.hessian_rank; });
  if (name == "kept") return kept(r);
  if (name == "smallest_pivot")
    return column<float>(r, [](const FitReport& f) { return f.smallest_pivot; });
  if (name == "amplification")
    return column<float>(r, [](const FitReport& f) { return f.amplification; });
  if (name == "gradient_amplification")
    return column<float>(r, [](const FitReport& f) { return f.gradient_amplification; });
  bindings::refuse_name("member of the report", name, names());
}

FitStatus status_of(py::handle object) {
  const std::string name = enumerator_name(object, "status");
  std::vector<std::string> valid;
  for (int i = 0; i <= static_cast<int>(FitStatus::too_far); ++i) {
    const auto status = static_cast<FitStatus>(i);
    if (name == name_of(status)) return status;
    valid.emplace_back(name_of(status));
  }
  bindings::refuse_name("status", name, valid);
}

std::string summary_text(const PyReports& reports) {
  return reading(reports, [](const FitReports& all) {
    const FitSummary& s = all.summary();
    std::ostringstream out;
    out << s.targets << " targets: " << s.full << " full";
    const auto also = [&](std::size_t count, const char* what) {
      if (count > 0) out << ", " << count << ' ' << what;
    };
    also(s.reduced, "reduced");
    also(s.nearest, "nearest");
    also(s.no_support, "without support");
    also(s.too_far, "too far");
    also(s.handed_over, "handed over to another solver");
    out.precision(3);
    out << "\nneighbours: " << s.fewest_neighbours << " to " << s.most_neighbours << ", mean "
        << s.mean_neighbours << "\nsmallest pivot " << s.smallest_pivot
        << ", largest amplification " << s.largest_amplification;
    return out.str();
  });
}

}  // namespace

void define_reports(py::module_& m) {
  py::class_<PyReports> reports(
      m, "FitReports", R"(What became of each target: a mapping of names to arrays of shape (m,).

neighbours              particles with positive weight
rank                    independent terms kept
degree                  all polynomials up to this degree are reproduced; -1: none
status                  a number of recon.FitStatus
solver                  a number of recon.Solver: the one that gave the result
gradient_rank           directions in which the gradient is resolved
hessian_rank            directions in which all second derivatives are resolved
kept                    directions kept within each degree, shape (m, 9)
smallest_pivot          of the scaled moment matrix, a bound of its reciprocal condition number
amplification           a bound of sum_p |phi_p|: how much errors of the data can grow
gradient_amplification  the same for slopes, in units of 1 / support radius

Each array is made when it is asked for, of the fit as it is then.)");
  for (const std::string& name : names())
    reports.def_property_readonly(name.c_str(),
                                  [name](const PyReports& r) { return column_named(r, name); });
  reports.def("__getitem__", &column_named)
      .def("keys", [](const PyReports&) { return py::cast(names()); })
      .def("values",
           [](const PyReports& r) {
             py::list all;
             for (const std::string& name : names()) all.append(column_named(r, name));
             return all;
           })
      .def("items",
           [](const PyReports& r) {
             py::list all;
             for (const std::string& name : names())
               all.append(py::make_tuple(name, column_named(r, name)));
             return all;
           })
      .def("__iter__", [](const PyReports&) { return py::iter(py::cast(names())); })
      .def("__contains__",
           [](const PyReports&, const std::string& name) {
             return std::find(names().begin(), names().end(), name) != names().end();
           })
      .def("__len__", [](const PyReports&) { return names().size(); })
      .def_property_readonly("targets",
                             [](const PyReports& r) {
                               return reading(r, [](const FitReports& all) { return all.size(); });
                             })
      .def(
          "reduced",
          [](const PyReports& r) {
            return reading(r, [](const FitReports& all) { return all.reduced(); });
          },
          "The number of targets whose degree is below the asked one.")
      .def(
          "no_support",
          [](const PyReports& r) {
            return reading(r, [](const FitReports& all) { return all.no_support(); });
          },
          "The number of targets without a particle in their support.")
      .def(
          "too_far",
          [](const PyReports& r) {
            return reading(r, [](const FitReports& all) { return all.too_far(); });
          },
          "The number of targets beyond max_distance.")
      .def(
          "with_status",
          [](const PyReports& r, py::object status) {
            const FitStatus asked = status_of(status);
            return reading(r, [&](const FitReports& all) -> py::array {
              std::vector<std::int64_t> rows;
              for (const std::size_t t : all.with_status(asked))
                rows.push_back(static_cast<std::int64_t>(t));
              return vector_array(std::move(rows));
            });
          },
          py::arg("status"), "The targets with this status, ascending.")
      .def(
          "totals",
          [](const PyReports& r) {
            return reading(r, [](const FitReports& all) {
              const FitSummary& s = all.summary();
              py::dict out;
              out["targets"] = s.targets, out["full"] = s.full, out["reduced"] = s.reduced;
              out["nearest"] = s.nearest, out["no_support"] = s.no_support,
              out["too_far"] = s.too_far;
              out["handed_over"] = s.handed_over;
              out["fewest_neighbours"] = s.fewest_neighbours,
              out["most_neighbours"] = s.most_neighbours;
              out["mean_neighbours"] = s.mean_neighbours;
              out["smallest_pivot"] = s.smallest_pivot;
              out["largest_amplification"] = s.largest_amplification;
              return out;
            });
          },
          "Counts and extremes over all targets, a dict.")
      .def("summary", &summary_text, "Counts and extremes in a few words.")
      .def("__repr__",
           [](const PyReports& r) { return "<recon.FitReports: " + summary_text(r) + ">"; });
}

}  // namespace recon::python
