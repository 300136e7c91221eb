#include "lab.hpp"
namespace recon_bench {
Section run_grid(Lab&) {
  return {"Grids", "", {}, {}};
}
}  // namespace recon_bench
