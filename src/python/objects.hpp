// The objects that compute: Sources, reconstructions, operators, reports.
//
// They are of float or of double, as their points are. All of them may be used by several threads
// at once, and release the interpreter's lock while they compute. What changes them (an update)
// needs them alone: where another thread uses them, either call throws InUse instead of waiting, so
// that nothing can block for ever.
#pragma once

#include <memory>
#include <shared_mutex>
#include <stdexcept>
#include <variant>

#include "python/arrays.hpp"
#include "python/options.hpp"
#include "recon/operators/reconstruct.hpp"

namespace recon::python {

class InUse : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Guards one object that computes. Its locks are taken with that of the interpreter held, which is
// given up afterwards: as nobody waits for them, that blocks nobody.
class Guard {
 public:
  std::shared_lock<std::shared_mutex> read(const char* what) {
    std::shared_lock lock(mutex_, std::try_to_lock);
    if (!lock) throw InUse(std::string(what) + " is being updated by another call");
    return lock;
  }
  std::unique_lock<std::shared_mutex> write(const char* what) {
    std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock) throw InUse(std::string(what) + " cannot be updated while another call uses it");
    return lock;
  }

 private:
  std::shared_mutex mutex_;
};

inline constexpr const char* sources_name = "the object Sources";
inline constexpr const char* fit_name = "the object Reconstruction";

// A cloud that Sources, fits and operators share. A fit that was made of points has no Sources.
struct Cloud {
  std::variant<std::monostate, SourcesF, Sources> sources;
  Rows rows;
  Guard guard;
};

struct PySources {
  std::shared_ptr<Cloud> cloud;

  Precision precision() const {
    return cloud->sources.index() == 1 ? Precision::float32 : Precision::float64;
  }
};

struct PyFit {
  std::variant<ReconstructionF, Reconstruction> fit;
  std::shared_ptr<Cloud> cloud;
  Rows rows;  // of the particles of this fit
  std::optional<StructuredGrid<double>> grid;
  mutable Guard guard;

  Precision precision() const { return fit.index() == 0 ? Precision::float32 : Precision::float64; }
};

using AnyMap = std::variant<CsrOperator<float>, CsrOperator<double>, VectorOperator<float>,
                            VectorOperator<double>>;

// Never changes.
struct PyOperator {
  std::shared_ptr<const AnyMap> map;
  std::shared_ptr<Cloud> cloud;
  Rows rows;
  bool transposed = false;
};

// The reports of a fit, as they are when they are asked for, or those of a result that stays.
struct PyReports {
  std::shared_ptr<const PyFit> fit;
  std::shared_ptr<const FitReports> own;
};

// A fit or an operator as an operator; throws a TypeError for anything else.
PyOperator operator_of(py::handle object);
PyOperator values_of(const PyFit& fit);

// The calls that recon.functions wraps: see there for what they do.
void define_sources(py::module_& module);
void define_reconstruction(py::module_& module);
void define_operators(py::module_& module);
void define_reports(py::module_& module);
void define_grid(py::module_& module);
void define_io(py::module_& module);
void define_simulation(py::module_& module);
void define_errors(py::module_& module);

}  // namespace recon::python
