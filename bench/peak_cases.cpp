// The machine's limits, measured: what the shares in the other sections refer to.
#include <algorithm>

#include "lab.hpp"
#include "machine.hpp"
#include "peak.hpp"

namespace recon_bench {
namespace {

constexpr std::size_t times_last_level_cache = 8;
constexpr std::size_t most_bytes = std::size_t{1} << 30, fewest_bytes = std::size_t{256} << 20;

}  // namespace

Section run_peak(Lab& lab) {
  progress("the machine's limits");
  const std::size_t bytes =
      lab.context.smoke
          ? std::size_t{1} << 20
          : std::clamp(times_last_level_cache * last_level_cache_bytes(), fewest_bytes, most_bytes);
  Section section{"The machine's limits",
                  "Measured by programs compiled for this machine: fused multiply-adds on many "
                  "independent accumulators in vectors of " +
                      std::to_string(native_vector_bytes()) +
                      " bytes (a multiply-add counts as two operations), and memory bandwidth over "
                      "arrays of " +
                      std::to_string(bytes >> 20) +
                      " MiB: the sum of one array, and a = b + s c. The best of several runs each. "
                      "Shares of the bandwidth refer to the larger of the two.",
                  {},
                  {}};
  Table table("peak", {"threads", "double GFLOP/s", "float GFLOP/s", "read GB/s", "triad GB/s"});
  std::vector<int> counts{1};
  if (lab.context.threads > 1) counts.push_back(lab.context.threads);
  for (const int threads : counts) {
    const double wide = measured_flops<double>(threads), narrow = measured_flops<float>(threads);
    const double read = measured_read_bandwidth(bytes, threads);
    const double triad = measured_triad_bandwidth(bytes, threads);
    table.add({std::to_string(threads), number(wide / 1e9), number(narrow / 1e9),
               number(read / 1e9), number(triad / 1e9)});
    if (threads == 1) {
      lab.limits.flops_double_one = wide;
      lab.limits.flops_float_one = narrow;
      lab.limits.bandwidth_one = std::max(read, triad);
    }
    lab.limits.flops_double = wide;
    lab.limits.flops_float = narrow;
    lab.limits.bandwidth = std::max(read, triad);
  }
  section.tables = {table};
  return section;
}

}  // namespace recon_bench
