// Exceptions of recon as exceptions of Python, with the same messages.
#include "python/objects.hpp"
#include "recon/core/progress.hpp"
#include "recon/io/error.hpp"
#include "recon/mpm/nodes.hpp"

namespace recon::python {
namespace {

// Kept for the life of the interpreter.
PyObject *invalid_argument = nullptr, *cancelled = nullptr, *file_error = nullptr,
         *failure = nullptr;

PyObject* new_exception(py::module_& m, const char* name, const char* text, py::handle base) {
  PyObject* type =
      PyErr_NewExceptionWithDoc((std::string("recon.") + name).c_str(), text, base.ptr(), nullptr);
  if (!type) throw py::error_already_set();
  m.attr(name) = py::handle(type);
  return type;
}

}  // namespace

void define_errors(py::module_& m) {
  invalid_argument =
      new_exception(m, "InvalidArgument",
                    "Wrong input: str() reads \"<argument> = <value>: <rule>\", and these are the "
                    "attributes argument, value and rule.",
                    PyExc_ValueError);
  cancelled =
      new_exception(m, "Cancelled", "Raised by a call whose progress function has returned False.",
                    PyExc_RuntimeError);
  file_error = new_exception(
      m, "FileError",
      "Trouble with a file: str() names file, line and rule; the attributes are path and "
      "line (0 where no line is to blame).",
      PyExc_OSError);
  failure = new_exception(
      m, "Failure",
      "Raised where a simulation cannot go on: str() names particle or node; the attributes are "
      "step and number.",
      PyExc_RuntimeError);
  py::register_exception_translator([](std::exception_ptr error) {
    try {
      if (error) std::rethrow_exception(error);
    } catch (const InvalidArgument& e) {
      py::object made = py::handle(invalid_argument)(e.what());
      made.attr("argument") = e.argument();
      made.attr("value") = e.value();
      made.attr("rule") = e.rule();
      PyErr_SetObject(invalid_argument, made.ptr());
    } catch (const py::cast_error&) {
      PyErr_SetString(PyExc_TypeError,
                      "an argument, or what a function has returned, is of the wrong type");
    } catch (const Cancelled& e) {
      PyErr_SetString(cancelled, e.what());
    } catch (const FileError& e) {
      py::object made = py::handle(file_error)(e.what());
      made.attr("path") = e.path().string();
      made.attr("line") = e.line();
      PyErr_SetObject(file_error, made.ptr());
    } catch (const mpm::Failure& e) {
      py::object made = py::handle(failure)(e.what());
      made.attr("step") = e.step();
      made.attr("number") = e.number();
      PyErr_SetObject(failure, made.ptr());
    }
  });
}

}  // namespace recon::python
