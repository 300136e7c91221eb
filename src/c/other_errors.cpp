#include "c/other_errors.hpp"

#include "recon/io/error.hpp"
#include "recon/mpm/nodes.hpp"

namespace recon::c {

recon_status status_of_other(const std::exception& error) noexcept {
  if (dynamic_cast<const FileError*>(&error)) return RECON_FILE_ERROR;
  if (dynamic_cast<const mpm::Failure*>(&error)) return RECON_FAILURE;
  return RECON_UNEXPECTED;
}

}  // namespace recon::c
