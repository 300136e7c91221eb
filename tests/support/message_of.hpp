// The words of an InvalidArgument, to look for what they must name.
#pragma once

#include <string>

#include "recon/core/error.hpp"

namespace recon::testing {

template <class Call>
std::string message_of(Call&& call) {
  try {
    call();
  } catch (const InvalidArgument& error) {
    return error.what();
  }
  return "no InvalidArgument was thrown";
}

}  // namespace recon::testing
