// The subcommands: each adds its options to the command line and gives back what to run.
#pragma once

#include "programs/common/command_line.hpp"

namespace recon::program {

Command add_convert(CLI::App& app);
Command add_info(CLI::App& app);
Command add_map(CLI::App& app, const Launch& launch);
Command add_profile(CLI::App& app);

}  // namespace recon::program
