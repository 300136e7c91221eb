// The names of fmt that LAMMPS' headers mention. Debian installs these headers without LAMMPS' copy
// of fmt; the functions that take such arguments are not called here, so that declarations are
// enough.
#pragma once

#include <string>

namespace fmt {
class string_view;
class format_args;
template <class... Args>
format_args make_args_checked(const std::string& format, const Args&... args);
}  // namespace fmt
