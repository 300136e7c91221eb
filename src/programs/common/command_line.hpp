// A program with subcommands: help, misspelt names, exit codes.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace recon::program {

class Launch;

// What a subcommand runs once the command line is read.
using Command = std::function<void()>;
// Makes the subcommands; those that are spread over ranks find them in the launch, which outlives
// the commands, when they are run.
using AddCommands = std::function<std::map<std::string, Command>(CLI::App&, const Launch&)>;

struct Front {
  std::string name;  // of the program
  // Answers a first word that is a file rather than a command, or is empty.
  std::string file_hint;
  // The commands that run where mpirun has started several processes; the others refuse.
  std::vector<std::string> on_ranks{};
};

// Parses the arguments and runs the subcommand. The exit code; whatever is wrong is said on the
// standard error.
int run_program(const Front& front, const std::string& description, int argc, char** argv,
                const AddCommands& add);

}  // namespace recon::program
