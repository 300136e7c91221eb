// toml++ with assertions that throw. Some texts that are no TOML violate them ("[[[a]]b]");
// otherwise the program would abort, or go on with wrong data.
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
