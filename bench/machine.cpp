#include "machine.hpp"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <fstream>

#include "hand_written.hpp"
#include "peak.hpp"
#include "recon/core/instruction_set.hpp"
#include "table.hpp"

namespace recon_bench {
namespace {

std::string processor_model() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const auto colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

std::string caches() {
  std::string text;
  for (const auto& cache : benchmark::CPUInfo::Get().caches)
    text += (text.empty() ? "L" : ", L") + std::to_string(cache.level) + " " + cache.type + " " +
            std::to_string(cache.size / 1024) + " KiB (shared by " +
            std::to_string(cache.num_sharing) + ")";
  return text.empty() ? "unknown" : text;
}

// A hexadecimal digit for each part.
std::string nanoflann_version() {
  const int version = hand_written::nanoflann_version();
  return std::to_string(version >> 8) + "." + std::to_string(version >> 4 & 15) + "." +
         std::to_string(version & 15);
}

std::string instruction_sets() {
  std::string text;
  for (const auto set : recon::available_instruction_sets())
    text += (text.empty() ? "" : ", ") + std::string(name_of(set));
  return text;
}

// What else the machine was doing: times are worth less where this is not near 0.
std::string load() {
  double average = 0;
  if (getloadavg(&average, 1) != 1) return "unknown";
  return number(average);
}

std::string date() {
  const std::time_t now = std::time(nullptr);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%d %H:%M UTC", std::gmtime(&now));
  return text;
}

}  // namespace

std::size_t last_level_cache_bytes() {
  std::size_t largest = 0;
  for (const auto& cache : benchmark::CPUInfo::Get().caches)
    largest = std::max(largest, static_cast<std::size_t>(std::max(cache.size, 0)));
  return largest ? largest : std::size_t{32} << 20;
}

std::vector<std::pair<std::string, std::string>> machine_description(int threads) {
  return {{"date", date()},
          {"load of the last minute, at the start", load()},
          {"processor", processor_model()},
          {"cores", std::to_string(benchmark::CPUInfo::Get().num_cpus)},
          {"threads", std::to_string(threads)},
          {"caches", caches()},
          {"instruction sets of recon's kernels", instruction_sets()},
          {"compiler", RECON_BENCH_COMPILER},
          {"flags of recon", RECON_BENCH_FLAGS},
          {"flags of recon's kernels for avx2", RECON_BENCH_FLAGS_AVX2},
          {"flags of recon's kernels for avx512", RECON_BENCH_FLAGS_AVX512},
          {"flags of the hand-written loop", RECON_BENCH_NATIVE_FLAGS},
          {"vector bytes of the hand-written loop", std::to_string(native_vector_bytes())},
          {"recon", RECON_BENCH_VERSION},
          {"Eigen", hand_written::eigen_version()},
          {"nanoflann", nanoflann_version()}};
}

}  // namespace recon_bench
