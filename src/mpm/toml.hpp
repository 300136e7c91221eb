// toml++, whose assertions throw. Some texts that are no TOML break them ("[[[a]]b]"), which would
// abort, or go on with what was assumed.
#pragma once

#include <stdexcept>

namespace recon::mpm {

class BrokenAssumption : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

[[noreturn]] inline void break_assumption(const char* what) {
  throw BrokenAssumption(what);
}

}  // namespace recon::mpm

// toml++ drops its assertions with NDEBUG, whatever is defined here.
#pragma push_macro("NDEBUG")
#undef NDEBUG
#define TOML_ASSERT(expression) \
  ((expression) ? static_cast<void>(0) : ::recon::mpm::break_assumption(#expression))
#include <toml++/toml.h>
#pragma pop_macro("NDEBUG")
