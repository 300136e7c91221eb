// What the speed cases share: the context, the stopwatch, the aims, the checks, and the
// machine's limits.
#pragma once

#include <cstddef>
#include <string>

#include "checks.hpp"
#include "context.hpp"
#include "summary.hpp"
#include "timing.hpp"

namespace recon_bench {

// Measured rates of this machine (peak.hpp), for one thread and for Context::threads.
struct Limits {
  double flops_double = 0, flops_float = 0;  // Context::threads
  double bandwidth = 0;                      // bytes/s, the better of read and triad
  double flops_double_one = 0, flops_float_one = 0, bandwidth_one = 0;  // one thread
};

struct Lab {
  const Context& context;
  Stopwatch& stopwatch;
  Summary& summary;
  Checks& checks;
  Limits limits{};

  // A number of things for the full run, the quick one, and the smoke test.
  std::size_t choose(std::size_t full, std::size_t quick, std::size_t smoke) const {
    return context.smoke ? smoke : context.quick ? quick : full;
  }
};

// One file each: <name>_cases.cpp.
Section run_peak(Lab& lab);  // first: it sets Lab::limits
Section run_cloud(Lab& lab);
Section run_search(Lab& lab);
Section run_apply(Lab& lab);
Section run_sources(Lab& lab);
Section run_grid(Lab& lab);
Section run_instruction_sets(Lab& lab);
Section run_scaling(Lab& lab);
Section run_memory(Lab& lab);
#ifdef RECON_BENCH_HAS_MPM
Section run_mpm(Lab& lab);
#endif

// `table` is a CSV file that bench/peers.py wrote.
Section run_peers(Lab& lab, const std::string& table);

}  // namespace recon_bench
