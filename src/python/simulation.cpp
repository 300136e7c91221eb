#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <chrono>

#include "bindings/any_simulation.hpp"
#include "python/objects.hpp"
#include "recon/core/progress.hpp"
#include "recon/mpm/method.hpp"

namespace recon::python {
namespace {

using bindings::AnySimulation;

constexpr const char* simulation_name = "the object Simulation";

struct PySimulation {
  AnySimulation own;
  mutable Guard guard;
};

// A copy: what a view shows would change, or go, with the next step.
py::array copy_of(const bindings::ParticleArrayView& view) {
  std::vector<py::ssize_t> shape(view.shape.begin(), view.shape.end());
  std::vector<py::ssize_t> strides(view.strides.begin(), view.strides.end());
  const py::dtype type = view.integers ? py::dtype::of<std::int32_t>() : py::dtype::of<double>();
  return py::array(type, shape, strides, view.data);
}

// Python looks for signals, and tells the callback, at most ten times a second.
class Between {
 public:
  Between(py::object callback, const AnySimulation& simulation)
      : callback_(shared(callback)), simulation_(simulation) {
    if (!callback.is_none()) require_callable(callback, "progress");
  }

  void operator()() {
    const auto now = std::chrono::steady_clock::now();
    if (now < next_) return;
    next_ = now + std::chrono::milliseconds(100);
    const py::gil_scoped_acquire lock;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (callback_->is_none()) return;
    const py::object answer = (*callback_)(simulation_.time());
    if (!answer.is_none() && !answer.cast<bool>()) throw Cancelled();
  }

 private:
  std::shared_ptr<py::object> callback_;
  const AnySimulation& simulation_;
  std::chrono::steady_clock::time_point next_ = std::chrono::steady_clock::now();
};

template <class Call>
auto changing(PySimulation& self, Call&& call) {
  const auto lock = self.guard.write(simulation_name);
  const py::gil_scoped_release release;
  return call(self.own);
}

template <class Call>
auto reading(const PySimulation& self, Call&& call) {
  const auto lock = self.guard.read(simulation_name);
  return call(self.own);
}

}  // namespace

void define_simulation(py::module_& m) {
  py::class_<PySimulation> simulation(m, "Simulation",
                                      R"(A problem of the material point method, step by step.

Parameters
----------
problem : path
    A TOML file; docs/mpm.md lists its keys.
**settings
    Values that replace those of the file: ``method="cpls"``, ``cells=40``; ``settings={"grid.cells": 40}`` where a
    name alone does not say which table is meant.

Raises
------
FileError
    For everything that is wrong with the file: file, line, key and the valid choices.

Examples
--------
>>> simulation = recon.mpm.Simulation("examples/mpm/disks.toml")
>>> while simulation.time < simulation.end:
...     simulation.step()
>>> x, v = simulation.particles["x"], simulation.particles["v"])");
  simulation
      .def(
          py::init([](const std::filesystem::path& path, const std::vector<std::string>& settings) {
            const py::gil_scoped_release release;
            return std::unique_ptr<PySimulation>(new PySimulation{{path, settings}, {}});
          }),
          py::arg("path"), py::arg("settings"))
      .def_property_readonly("title", [](const PySimulation& s) { return s.own.title(); })
      .def_property_readonly("method", [](const PySimulation& s) { return s.own.method(); })
      .def_property_readonly("dimension", [](const PySimulation& s) { return s.own.dimension(); })
      .def_property_readonly(
          "size", [](const PySimulation& s) { return s.own.size(); }, "The number of particles.")
      .def_property_readonly(
          "end", [](const PySimulation& s) { return s.own.end(); },
          "The end of the problem; infinity where it has none.")
      .def_property_readonly("time",
                             [](const PySimulation& s) {
                               return reading(s,
                                              [](const AnySimulation& own) { return own.time(); });
                             })
      .def_property_readonly(
          "steps",
          [](const PySimulation& s) {
            return reading(s, [](const AnySimulation& own) { return own.steps(); });
          },
          "Steps made so far.")
      .def(
          "choose_step",
          [](const PySimulation& s) {
            return reading(s, [](const AnySimulation& own) {
              const py::gil_scoped_release release;
              return own.choose_step();
            });
          },
          "The length of step that the rule of the problem gives.")
      .def(
          "step",
          [](PySimulation& s, std::optional<double> dt) {
            return changing(s, [&](AnySimulation& own) {
              const double length = dt ? *dt : own.choose_step();
              own.step(length);
              return length;
            });
          },
          py::arg("dt") = py::none(), R"(One step, of the problem's rule where dt is not given.

Returns
-------
float
    The length of the step.

Raises
------
Failure
    Where the particles cannot go on.)")
      .def(
          "run_until",
          [](PySimulation& s, double time, py::object progress) {
            const auto between = std::make_shared<Between>(std::move(progress), s.own);
            changing(s, [&](AnySimulation& own) {
              own.run_until(time, [between] { (*between)(); });
              return 0;
            });
          },
          py::arg("time"), py::arg("progress") = py::none(),
          R"(Steps of the problem's rule until this time, to rounding.

Parameters
----------
time : float
progress : callable, optional
    ``progress(time)`` is called at most ten times a second; False ends the run between two steps.)")
      .def(
          "particle_array",
          [](const PySimulation& s, const std::string& name) {
            return reading(s,
                           [&](const AnySimulation& own) { return copy_of(own.particles(name)); });
          },
          py::arg("name"))
      .def("particle_arrays",
           [](const PySimulation& s) {
             return reading(s, [](const AnySimulation& own) { return own.particle_arrays(); });
           })
      .def(
          "node_array",
          [](PySimulation& s, const std::string& name) {
            if (!reading(s, [](const AnySimulation& own) { return own.mapped(); }))
              changing(s, [](AnySimulation& own) {
                own.map();
                return 0;
              });
            return reading(s, [&](const AnySimulation& own) { return copy_of(own.nodes(name)); });
          },
          py::arg("name"))
      .def(
          "account",
          [](PySimulation& s) {
            if (!reading(s, [](const AnySimulation& own) { return own.mapped(); }))
              changing(s, [](AnySimulation& own) {
                own.map();
                return 0;
              });
            return reading(s, [](const AnySimulation& own) {
              py::dict out;
              for (const auto& [name, number] : own.account()) out[py::str(name)] = number;
              return out;
            });
          },
          "Momenta and energies as ledger.csv has them, a dict.")
      .def_property_readonly(
          "grid",
          [](const PySimulation& s) {
            const AnySimulation::Grid grid = s.own.grid();
            StructuredGrid<double> out;
            out.dimension = static_cast<int>(grid.counts.size());
            for (int d = 0; d < out.dimension; ++d) {
              out.origin[d] = grid.origin[static_cast<std::size_t>(d)];
              out.spacing[d] = grid.spacing[static_cast<std::size_t>(d)];
              out.counts[d] = grid.counts[static_cast<std::size_t>(d)];
            }
            return out;
          },
          "The nodes, a StructuredGrid.")
      .def("__repr__", [](const PySimulation& s) {
        return "<recon.mpm.Simulation '" + s.own.title() + "' by " + s.own.method() + ", " +
               std::to_string(s.own.size()) + " particles>";
      });
  m.def("mpm_methods", [] {
    std::vector<std::string> names;
    for (const mpm::Method& method : mpm::methods()) names.push_back(method.name);
    return names;
  });
}

}  // namespace recon::python
