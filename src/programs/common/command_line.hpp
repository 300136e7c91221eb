// A program with subcommands: help, misspelt names, exit codes.
#pragma once

#include <functional>
#include <map>
#include <string>

namespace CLI {
class App;
}

namespace recon::program {

// What a subcommand runs once the command line is read.
using Command = std::function<void()>;

struct Front {
  std::string name;  // of the program
  // Answers a first word that is a file rather than a command, or is empty.
  std::string file_hint;
  // Whether what is wrong is left to another process to say.
  bool silent = false;
};

// Parses the arguments and runs the subcommand. The exit code; whatever is wrong is said on the
// standard error. `add` makes the subcommands.
int run_program(const Front& front, const std::string& description, int argc, char** argv,
                const std::function<std::map<std::string, Command>(CLI::App&)>& add);

}  // namespace recon::program
