// recon._recon: the compiled part of the Python module.
#include "python/objects.hpp"
#include "recon/core/parallel.hpp"

PYBIND11_MODULE(_recon, m) {
  namespace python = recon::python;
  pybind11::options options;
  options.disable_function_signatures();  // the types are in the stubs, the shapes in the texts
  m.attr("__version__") = RECON_VERSION;
  m.def("default_threads", &recon::default_threads,
        "The number of threads of calls that do not say one; 1 in a child of fork().");
  python::define_errors(m);
  python::define_options(m);
  python::define_sources(m);
  python::define_operators(m);
  python::define_reports(m);
  python::define_reconstruction(m);
  python::define_grid(m);
  python::define_io(m);
  python::define_simulation(m);
}
