#include <new>

#include "c/handles.hpp"
#include "c/other_errors.hpp"
#include "recon/core/progress.hpp"

namespace {

thread_local std::string message;
thread_local const char* shown = "";

}  // namespace

namespace recon::c {

recon_status status_of(std::exception_ptr error) noexcept {
  const auto say = [](recon_status status, const char* what) noexcept {
    try {
      message = what;
      shown = message.c_str();
    } catch (...) {
      shown = "no memory for a message";
    }
    return status;
  };
  try {
    std::rethrow_exception(error);
  } catch (const InvalidArgument& e) {
    return say(RECON_INVALID_ARGUMENT, e.what());
  } catch (const Cancelled& e) {
    return say(RECON_CANCELLED, e.what());
  } catch (const std::bad_alloc&) {
    return say(RECON_NO_MEMORY, "there is not enough memory");
  } catch (const std::exception& e) {
    return say(status_of_other(e), e.what());
  } catch (...) {
    return say(RECON_UNEXPECTED, "an exception of an unknown type");
  }
}

}  // namespace recon::c

int recon_abi_version(void) {
  return RECON_C_ABI;
}
const char* recon_version(void) {
  return RECON_VERSION;
}
const char* recon_message(void) {
  return shown;
}
