// Exit codes of the program, and the exceptions that lead to them.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

#include "recon/core/error.hpp"
#include "recon/io/error.hpp"

namespace recon::program {

// 128 + N: stopped by signal N.
enum ExitCode : int {
  success = 0,
  wrong_usage = 1,
  wrong_input = 2,
  no_output = 3,
  internal_error = 4
};

class ProgramError : public std::runtime_error {
 public:
  ProgramError(ExitCode code, const std::string& what) : std::runtime_error(what), code_(code) {}
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

// What all ranks throw alike, and the first one says.
class FailureOfAll : public ProgramError {
 public:
  using ProgramError::ProgramError;
};

// What an exception says, and the code that the program ends with.
struct Failure {
  ExitCode code = success;
  std::string text;
};

// Of the exception that is being handled.
Failure failure();
// Says it on the standard error, after what was printed.
void say(const std::string& program, const std::string& what);

[[noreturn]] inline void fail_usage(const std::string& what) {
  throw ProgramError(wrong_usage, what);
}
[[noreturn]] inline void fail_input(const std::string& what) {
  throw ProgramError(wrong_input, what);
}

// Runs `work`; what it finds wrong with files or numbers ends the program with `code`.
template <class Work>
decltype(auto) with_exit_code(ExitCode code, Work&& work) {
  try {
    return std::forward<Work>(work)();
  } catch (const FileError& error) {
    throw ProgramError(code, error.what());
  } catch (const InvalidArgument& error) {
    throw ProgramError(code, error.what());
  }
}

}  // namespace recon::program
