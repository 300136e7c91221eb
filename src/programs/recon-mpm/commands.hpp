// The subcommands of recon-mpm.
#pragma once

#include "programs/common/command_line.hpp"

namespace recon::program {

Command add_run(CLI::App& app, const Launch& launch);
Command add_methods(CLI::App& app);
Command add_converge(CLI::App& app);
Command add_compare(CLI::App& app);
Command add_verify(CLI::App& app);
Command add_stability(CLI::App& app);

}  // namespace recon::program
