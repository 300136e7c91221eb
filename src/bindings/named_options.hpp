// Options as other languages say them: by name, with a number or a text.
//
// Names are those of the members of Options, "grow.steps" and "tolerances.rank" for members of
// these, and short forms for what is said most:
//   method    "shepard" (degree 0), "mls" (moment_matrix) or "imls" (gram_schmidt)
//   radius    Radius{radius}
//   nearest   Nearest{nearest}; together with radius NearestWithin{nearest, radius}
// Enumerators are said by their names in C++. What other languages give in another way (arrays,
// functions) they set in `options` themselves, and say so with said().
#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>

#include "recon/operators/limit.hpp"
#include "recon/shape/options.hpp"

namespace recon::bindings {

class NamedOptions {
 public:
  Options options;

  // Throws InvalidArgument for a name that is no option (with the nearest valid ones), for one that
  // wants the other kind of value, an unknown enumerator, and a number that must be whole and is
  // not.
  void set(std::string_view name, double number);
  void set(std::string_view name, std::string_view text);

  // Notes that an option was given. Throws as set() does for a name that is none.
  void said(std::string_view name);

  // With the short forms worked in. Throws InvalidArgument where two options contradict each other.
  Options finished() const;

 private:
  std::set<std::string, std::less<>> said_;
  std::optional<double> radius_;
  std::optional<std::size_t> nearest_;
  std::string method_;
};

// Throws InvalidArgument as NamedOptions::set() does for a name that is no option.
void require_option(std::string_view name);

// Throws InvalidArgument for a name that is not among the valid ones, and suggests the nearest.
[[noreturn]] void refuse_name(const char* argument, std::string_view name,
                              std::span<const std::string> valid);

// The enumerator of this name. Throws InvalidArgument with the nearest valid names.
Weight weight_of(std::string_view name);  // also by the short names of weights/weight.hpp
WeightForm form_of(std::string_view name);
Solver solver_of(std::string_view name);
SearchMethod search_of(std::string_view name);
Unsupported unsupported_of(std::string_view name);
InstructionSet instruction_set_of(std::string_view name);
Derivative derivative_of(std::string_view name);
Limit limit_of(std::string_view name);
PairSupport pair_support_of(std::string_view name);

// A whole number in a range that std::size_t holds. Throws InvalidArgument for others.
std::size_t whole_number(const char* argument, double number);

}  // namespace recon::bindings
