// Calls of PETSc and MPI whose codes become exceptions, and objects of PETSc that end themselves.
#pragma once

#include <petscsys.h>

#include <type_traits>
#include <utility>

#include "recon/petsc/communicator.hpp"

namespace recon::petsc {

static_assert(std::is_same_v<PetscScalar, double>, "recon::petsc needs a PETSc of real doubles");

// Calls PETSc; throws Error with the first thing that PETSc has said of a failure.
template <class Call>
void call_petsc(const char* text, const Call& call) {
  std::string said;
  const auto listen = [](MPI_Comm, int, const char*, const char*, PetscErrorCode code,
                         PetscErrorType type, const char* message, void* context) {
    auto& first = *static_cast<std::string*>(context);
    if (type == PETSC_ERROR_INITIAL && first.empty() && message) first = message;
    return code;
  };
  PetscPushErrorHandler(listen, &said);
  const PetscErrorCode code = call();
  PetscPopErrorHandler();
  if (code) throw Error(text, static_cast<int>(code), said);
}

void check_mpi(const char* text, int code);

#define RECON_PETSC(...) \
  ::recon::petsc::call_petsc(#__VA_ARGS__, [&]() -> PetscErrorCode { return __VA_ARGS__; })
#define RECON_MPI(...) ::recon::petsc::check_mpi(#__VA_ARGS__, __VA_ARGS__)

// Has PETSc begun, and not ended yet? Objects that live longer than PETSc are left to it.
bool petsc_is_there();

// One object of PETSc (DM, Vec, PetscSF), which is destroyed with this.
template <class Object, PetscErrorCode (*destroy)(Object*)>
class Owned {
 public:
  Owned() = default;
  Owned(Owned&& other) noexcept : object_(std::exchange(other.object_, nullptr)) {}
  Owned& operator=(Owned&& other) noexcept {
    std::swap(object_, other.object_);
    return *this;
  }
  ~Owned() {
    if (object_ && petsc_is_there()) destroy(&object_);
  }

  operator Object() const { return object_; }
  Object* out() { return &object_; }

 private:
  Object object_ = nullptr;
};

// As an integer of PETSc; throws InvalidArgument where it is not in their range.
template <class Number>
PetscInt to_petsc_int(Number number, const char* what) {
  detail::require(number >= 0 && static_cast<unsigned long long>(number) <=
                                     static_cast<unsigned long long>(PETSC_MAX_INT),
                  what, number, "must be within the range of PETSc's integers");
  return static_cast<PetscInt>(number);
}

}  // namespace recon::petsc
