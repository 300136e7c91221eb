// Wrong input, answered with an exception that names the argument, its value and the rule it broke.
//
// recon keeps two kinds of trouble apart. Wrong input (sizes that disagree, NaN, a negative
// support, an unknown name) throws InvalidArgument. A numerical outcome (too few neighbours, rank
// loss) is not an error: it is data, and stands in the FitReport of its target
// (local_solve/report.hpp).
#pragma once

#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

// A call that throws, in a function that may be compiled for a GPU as well. Device code cannot
// throw: wrong input ends the kernel there, with an error that the host's next call sees.
#if defined(__CUDA_ARCH__)
#define RECON_REFUSE(call) __trap()
#else
#define RECON_REFUSE(call) call
#endif

namespace recon {

// Thrown for wrong input. what() reads "<argument> = <value>: <rule>".
class InvalidArgument : public std::invalid_argument {
 public:
  InvalidArgument(std::string argument, std::string value, std::string rule)
      : std::invalid_argument(argument + " = " + value + ": " + rule),
        argument_(std::move(argument)),
        value_(std::move(value)),
        rule_(std::move(rule)) {}

  const std::string& argument() const { return argument_; }
  const std::string& value() const { return value_; }
  const std::string& rule() const { return rule_; }

 private:
  std::string argument_, value_, rule_;
};

namespace detail {

template <class Value>
std::string to_text(const Value& value) {
  std::ostringstream out;
  out.precision(17);
  if constexpr (requires { out << value; })
    out << value;
  else
    out << static_cast<double>(value);  // a number type of the user's own
  return out.str();
}

template <class Value>
[[noreturn]] void throw_invalid(std::string argument, const Value& value, std::string rule) {
  throw InvalidArgument(std::move(argument), to_text(value), std::move(rule));
}

// Throws InvalidArgument(argument, value, rule) unless `holds`. Its texts are built only then.
template <class Value>
constexpr void require(bool holds, const char* argument, const Value& value, const char* rule) {
  if (!holds) [[unlikely]]
    RECON_REFUSE(throw_invalid(argument, value, rule));
}

}  // namespace detail
}  // namespace recon
