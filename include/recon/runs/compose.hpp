// Methods and their choices as texts: those of problem files, of command lines and of checkpoints.
//
// ```cpp
//   recon::mpm::Method method = recon::mpm::composed("cpdi1+velocity=affine+flip+blend=0.05");
//   recon::mpm::set_choice(method, "stress", "musl");
//   method.validate(2);  // throws where a choice needs what another one does not have
// ```
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "recon/mpm/method.hpp"

namespace recon::mpm {

// The keys of the choices of a method, in the order of problem files and checkpoints.
std::vector<std::string> method_keys();
// The words that a choice can be; empty for numbers and flags. Throws InvalidArgument for an
// unknown key, with the nearest ones.
std::vector<std::string> words_of(std::string_view key);

// A choice by its key: a word, a number, true or false. Throws InvalidArgument for a key or a value
// that there is not, with the nearest ones.
void set_choice(Method& method, std::string_view key, std::string_view value);
std::string choice_text(const Method& method, std::string_view key);

// A row with other choices: "ROW+key=value+..." or, where a value is a word of one key alone,
// "ROW+value". That text is its name. Throws InvalidArgument for what there is not, and for a choice
// that is said twice.
Method composed(std::string_view text);
// The keys of the choices that such a text says, in its order.
std::vector<std::string> keys_of(std::string_view text);

}  // namespace recon::mpm
