// What the results depend on: the machine, the compilers and flags, the versions.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace recon_bench {

// Names and texts, in the order in which they are read.
std::vector<std::pair<std::string, std::string>> machine_description(int threads);

// Of all caches together that the threads share; 32 MiB where the system does not say.
std::size_t last_level_cache_bytes();

}  // namespace recon_bench
