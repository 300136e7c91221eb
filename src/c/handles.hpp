// What stands behind the handles of recon/c/recon.h.
#pragma once

#include <exception>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "bindings/named_options.hpp"
#include "recon/c/recon.h"
#include "recon/operators/reconstruct.hpp"

struct recon_options {
  recon::bindings::NamedOptions named;
  std::vector<double> particle_weights, radii;
  bool has_radii = false;
  std::vector<double> tensors;
  int tensor_components = 0;  // 0: there are none
  std::shared_ptr<const recon::NeighbourList<double>> list;

  // With arrays that live as long as this.
  recon::Options finished() const;
};

struct recon_sources {
  std::variant<recon::SourcesF, recon::Sources> sources;
};

struct recon_fit {
  std::variant<recon::ReconstructionF, recon::Reconstruction> fit;
};

struct recon_operator {
  std::variant<recon::CsrOperator<float>, recon::CsrOperator<double>, recon::VectorOperator<float>,
               recon::VectorOperator<double>>
      op;
};

namespace recon::c {

// Notes what was thrown for recon_message().
recon_status status_of(std::exception_ptr error) noexcept;

// Calls, and turns what is thrown into a status.
template <class Call>
recon_status guarded(Call&& call) noexcept {
  try {
    call();
    return RECON_OK;
  } catch (...) {
    return status_of(std::current_exception());
  }
}

// As above for what makes an object: `made` is NULL where it fails.
template <class Handle, class Make>
recon_status made_by(Handle** made, Make&& make) noexcept {
  if (made) *made = nullptr;
  return guarded([&] {
    detail::require(made != nullptr, "the handle to be made", "NULL", "must be an address");
    *made = make().release();
  });
}

// Throws InvalidArgument for NULL.
template <class T>
T& there(T* pointer, const char* name) {
  detail::require(pointer != nullptr, name, "NULL", "must be given");
  return *pointer;
}

// Views of arrays in the precision Scalar. Throw InvalidArgument for another one, for NULL and for
// numbers of components that there cannot be.
template <class Scalar>
PointsView<Scalar> points_of(const recon_array& array, const char* name);
template <class Scalar>
FieldView<Scalar> field_of(const recon_array& array, const char* name = "field");
template <class Scalar>
FieldSpan<Scalar> span_of(const recon_array& array, std::size_t size, int components,
                          const char* name = "out");

template <class Scalar>
constexpr recon_number number_of = sizeof(Scalar) == 4 ? RECON_FLOAT : RECON_DOUBLE;

template <class Scalar>
NeighbourList<Scalar> list_as(const NeighbourList<double>& list);

}  // namespace recon::c
