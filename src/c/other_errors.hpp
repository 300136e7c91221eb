// Exceptions of the libraries that recon can be built without.
#pragma once

#include <exception>

#include "recon/c/recon.h"

namespace recon::c {

recon_status status_of_other(const std::exception& error) noexcept;

}  // namespace recon::c
