// What the programs were built with, for --version and for reports of faults.
#pragma once

#include <string>

namespace recon::program {

// Lines of a name and a text: compiler, instruction sets, OpenMP, what was found.
std::string build_options();

}  // namespace recon::program
