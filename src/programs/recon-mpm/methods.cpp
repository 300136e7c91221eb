// recon-mpm methods: the table of methods and their policies.
#include <cstdio>

#include "commands.hpp"
#include "programs/common/checks.hpp"
#include "recon/mpm/method.hpp"

namespace recon::program {

Command add_methods(CLI::App& app) {
  app.add_subcommand("methods", "the methods, and what they are made of");
  return [] {
    std::printf("%-14s %-8s %-14s %-10s %s\n", "method", "domain", "velocity", "quadrature",
                "source");
    for (const mpm::Method& method : mpm::methods())
      std::printf("%-14s %-8s %-14s %-10s %s\n", method.name.c_str(),
                  std::string(name_of(method.domain)).c_str(),
                  std::string(name_of(method.velocity)).c_str(),
                  std::string(name_of(method.quadrature)).c_str(), method.source.c_str());
  };
}

}  // namespace recon::program
