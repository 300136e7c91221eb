// recon-mpm methods: the table of methods and their policies.
#include <cstdio>

#include "commands.hpp"
#include "programs/common/checks.hpp"
#include "recon/mpm/method.hpp"

namespace recon::program {

Command add_methods(CLI::App& app) {
  app.add_subcommand("methods", "the methods, and what they are made of");
  return [] {
    const char* line = "%-20s %-7s %-13s %-14s %-13s %-12s %s\n";
    std::printf(line, "method", "domain", "basis", "velocity", "quadrature", "update", "source");
    for (const mpm::Method& method : mpm::methods())
      std::printf(line, method.name.c_str(), std::string(name_of(method.domain)).c_str(),
                  std::string(name_of(method.basis)).c_str(),
                  std::string(name_of(method.velocity)).c_str(),
                  std::string(name_of(method.quadrature)).c_str(),
                  std::string(name_of(method.update)).c_str(), method.source.c_str());
  };
}

}  // namespace recon::program
